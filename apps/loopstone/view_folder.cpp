#include "view_folder.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>
#include <variant>

#include "edited_folder.hpp"
#include "interrupt.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "loopstone/formats/text_file.hpp"
#include "loopstone/live/edit_desk.hpp"
#include "loopstone/live/folder_view.hpp"
#include "loopstone/live/replay_clock.hpp"
#include "loopstone/report/map_folder.hpp"
#include "output_path.hpp"
#include "progress_display.hpp"

namespace loopstone::app {

namespace {

namespace fs = std::filesystem;

bool go_on() { return !interrupted(); }

/// The words of a command line as summary.json has them: those with blanks stand in '...'.
std::vector<std::string> words_in(const std::string& command) {
  std::vector<std::string> words;
  std::string word;
  bool quoted = false;
  bool begun = false;
  for (const char c : command) {
    if (c == '\'') {
      quoted = !quoted;
      begun = true;
    } else if (c == ' ' && !quoted) {
      if (begun) words.push_back(std::exchange(word, {}));
      begun = false;
    } else {
      word += c;
      begun = true;
    }
  }
  if (begun) words.push_back(word);
  return words;
}

/// How the log of a folder was read.
struct LogOfFolder {
  std::string path{};
  LogFlags reading{};
  std::string robot{};
};

LogOfFolder log_of(const std::string& summary_json) {
  LogOfFolder log;
  const auto summary = nlohmann::json::parse(summary_json, nullptr, /*allow_exceptions=*/false);
  if (!summary.is_object()) return log;
  const auto text_of = [&](const char* name) {
    const auto found = summary.find(name);
    return found != summary.end() && found->is_string() ? found->get<std::string>() : std::string{};
  };
  log.path = text_of("log");
  CLI::App command;
  command.allow_extras();
  command.set_help_flag();
  add_log_flags(command, log.reading);
  command.add_option("--robot", log.robot);
  std::vector<std::string> words = words_in(text_of("command"));
  std::reverse(words.begin(), words.end());  // as CLI11 wants them
  try {
    command.parse(std::move(words));
  } catch (const CLI::ParseError&) {
    log.reading = {};
    log.robot.clear();
  }
  return log;
}

/// A path that was said from another folder may be one beside the results.
std::string found_from(const std::string& folder, const std::string& path) {
  std::error_code ignored;
  const std::string file = path.substr(0, path.find('#'));
  if (file.empty() || fs::exists(file, ignored)) return path;
  const fs::path beside = fs::path(folder) / path;
  return fs::exists(beside.string().substr(0, beside.string().find('#')), ignored) ? beside.string()
                                                                                   : path;
}

/// Why there are no scans is told; the map is shown all the same.
void add_scans(const ViewRequest& request, const LogOfFolder& log, FolderView& view,
               const AppContext& context) {
  const std::string path = request.log.empty() ? found_from(request.what, log.path) : request.log;
  if (path.empty() || is_stream(path)) return;
  try {
    ProgressDisplay display(context);
    const LogFlags& reading = request.log.empty() ? log.reading : request.reading;
    const auto reader =
        source_of(path, log_options(reading, context), context).open_ahead(context.threads());
    const bool has_robot = context.robot_given() || !log.robot.empty();
    CutLog scans(*reader, {}, !has_robot, "reading", watch_by(display));
    while (const auto message = scans.next()) {
      if (const auto* scan = std::get_if<LaserScan>(&*message)) view.add_scan(*scan);
    }
    ProgressDisplay::clear_line();
    if (view.scans() == 0 && !interrupted())
      context.warn(path + ": has none of the map's scans, so none are shown");
  } catch (const std::exception& error) {
    if (!request.log.empty()) throw;
    ProgressDisplay::clear_line();
    context.warn(std::string("scans are not shown: ") + error.what() +
                 "; --log LOG names them if they lie elsewhere");
  }
}

/// As the folder's map was made with.
RobotModel robot_for(const ViewRequest& request, const LogOfFolder& log,
                     const AppContext& context) {
  if (context.robot_given() || log.robot.empty()) return context.robot();
  try {
    return read_robot_file(found_from(request.what, log.robot));
  } catch (const DataError& error) {
    context.warn(std::string("the laser is taken to sit where it usually does: ") + error.what());
    return context.robot();
  }
}

/// Where edits are saved: beside the folder, which is never changed.
std::string edits_path(const ViewRequest& request) {
  if (!request.edits.empty()) return request.edits;
  std::string folder = request.what;
  while (folder.size() > 1 && folder.ends_with('/')) folder.pop_back();
  return folder + ".edits.toml";
}

/// The folder's map as something that clients edit. Nothing when that is not asked for.
std::unique_ptr<EditDesk> desk_of(const ViewRequest& request, LiveView& view,
                                  const AppContext& context) {
  if (!request.edit) return nullptr;
  const EditedFolder folder = read_edited_folder(request.what);
  KeptMap kept;
  SettledMap map = settle_kept_map(request.what, context, kept);
  const std::string file = edits_path(request);
  auto desk = std::make_unique<EditDesk>(
      map, folder.edits.edits, view.board(),
      EditDeskOptions{.file = file,
                      .command = "loopstone edit " + request.what + " --edits " + file + " -o " +
                                 short_name(request.what) + "-edited",
                      .save = [file](const std::string& toml) { write_text_file(file, toml); },
                      .threads = context.threads()});
  view.on_get([&desk = *desk](std::string_view path) { return desk.get(path); });
  view.server().on_post([&desk = *desk](std::string_view path, std::string_view body) {
    return desk.post(path, body);
  });
  return desk;
}

}  // namespace

bool is_map_folder(const std::string& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored) &&
         fs::exists(fs::path(path) / "trajectory.tum", ignored) &&
         fs::exists(fs::path(path) / "summary.json", ignored);
}

ExitCode view_folder(const ViewRequest& request, const AppContext& context) {
  if (!request.edits.empty() && !request.edit)
    throw UsageError("--edits says where --edit saves what was done; add --edit");
  MapFolder folder = read_map_folder(request.what, context.memory());
  for (const std::string& reason : folder.left_out) context.warn("not shown: " + reason);
  const LogOfFolder log = log_of(folder.summary_json);
  const RobotModel robot = robot_for(request, log, context);
  const HeldInterrupt held(kViewEnds);
  const PlaybackRange range{folder.trajectory.front().stamp, folder.trajectory.back().stamp};

  LiveView view(request.view, {short_name(request.what), "replay", range, request.edit});
  ReplayClock clock(range, request.speed,
                    [&](const PlaybackState& state) { view.server().set_playback(state); });
  view.server().on_playback([&](const PlaybackControl& control) { clock.control(control); });
  FolderView shown(std::move(folder), robot, view.board());
  add_scans(request, log, shown, context);
  const std::unique_ptr<EditDesk> desk = desk_of(request, view, context);
  if (interrupted()) return kExitDone;
  const ClosesFirst closes_first(view);
  view.open(context);
  tell_address(view, context);
  shown.play(clock, go_on);
  return kExitDone;
}

}  // namespace loopstone::app
