#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "interrupt.hpp"
#include "log_run.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/option_list.hpp"
#include "loopstone/formats/options_file.hpp"
#include "progress_display.hpp"
#include "result.hpp"
#include "site.hpp"

namespace loopstone::app {

namespace {

namespace fs = std::filesystem;

constexpr const char* kFooter = R"(
Each LOG is mapped by itself, as `loopstone map` does it, and looked for on the site without a guess:
  joined    it was recognised, and is part of the map
  pending   it was not, or in more than one place; it waits beside the map until a later session ties it
  refused   its own map is bad; only that is noted
In which order sessions are added changes nothing: they are joined in the order in which they were driven. A log that is in the
site already is refused. A new site keeps the options of -c and --set for all its maps. Ctrl-C leaves out the session in the making.

Examples:
  loopstone site add office.site monday.mcap tuesday.mcap
  loopstone site add office.site old.clf --date 2003-05-12     a log whose stamps tell no date)";

struct Arguments {
  std::string site;
  std::vector<std::string> logs;
  std::string date;
  double settled_s = 10.0;  ///< of watch
  bool once = false;
  LogCut cut;
  LogFlags reading;
};

std::optional<Stamp> date_of(const Arguments& arguments) {
  if (arguments.date.empty()) return {};
  const Stamp date = read_date("--date", arguments.date);
  if (arguments.logs.size() > 1)
    throw UsageError("--date is of one log; add the others by commands of their own");
  return date;
}

void make_site(const std::string& path, const AppContext& context) {
  MapOptions options = context.load_options(MapOptions{});
  SiteFile::create_where_missing(path, options_to_toml(list_options(options)));
}

struct Added {
  SiteSession session{};
  double map_s = 0.0;
  double join_s = 0.0;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Added add_log(Site& site, const std::string& log, const Arguments& arguments,
              const AppContext& context) {
  ProblemPrinter print_problem(context);
  LogFlags flags = arguments.reading;
  flags.pictures = false;
  const LogSource source = source_of(log, log_options(flags, context, &print_problem), context);
  const auto reader = source.open_ahead(context.threads());
  tell_choices(*reader, context);
  ProgressDisplay display(context);
  const auto start = std::chrono::steady_clock::now();
  MappedSession mapped = map_session(source, *reader, arguments.cut, site.options(),
                                     context.threads(), date_of(arguments), watch_by(display));
  ProgressDisplay::clear_line();
  Added added{.map_s = seconds_since(start)};
  if (!mapped.complete || interrupted())
    throw UsageError(log + ": was called off; the site stays as it was");
  mapped.session.log = fs::absolute(log).string();
  const auto mapped_at = std::chrono::steady_clock::now();
  added.session = site.add(mapped, site_watch(context));
  added.join_s = seconds_since(mapped_at);
  return added;
}

void add_row(const Added& added, Result& result) {
  const SiteSession& session = added.session;
  result.add_row(session.log,
                 fmt::format("{}{}; its own map is {}; mapped in {:.1f} s, looked for in {:.1f} s",
                             to_string(session.status),
                             session.status == SessionStatus::kJoined
                                 ? fmt::format(", tied by {} closures", session.closures)
                                 : ": " + session.reason,
                             session.verdict, added.map_s, added.join_s));
}

bool has_log(const Site& site, const std::string& log) {
  const std::string path = fs::absolute(log).string();
  for (const SiteSession& session : site.sessions())
    if (session.log == path) return true;
  return false;
}

nlohmann::ordered_json row_of(const Added& added) {
  nlohmann::ordered_json row = json_of(added.session);
  row["map_s"] = added.map_s;
  row["join_s"] = added.join_s;
  return row;
}

ExitCode run(const Arguments& arguments, const AppContext& context) {
  (void)date_of(arguments);
  make_site(arguments.site, context);
  const HeldInterrupt held("interrupted: the site stays as it is; once more ends it at once");
  Site site(arguments.site, SiteAccess::kWrite, context.threads());
  Result result;
  nlohmann::ordered_json sessions = nlohmann::ordered_json::array();
  bool failed = false;
  for (const std::string& log : arguments.logs) {
    if (interrupted()) return kExitInterrupted;
    if (has_log(site, log)) context.note(log + ": a log of this name is in the site already");
    try {
      const Added added = add_log(site, log, arguments, context);
      sessions.push_back(row_of(added));
      add_row(added, result);
    } catch (const std::runtime_error& error) {
      if (arguments.logs.size() == 1) throw;
      if (interrupted()) return kExitInterrupted;
      context.warn(error.what());
      failed = true;
    }
  }
  result.add_json("site", arguments.site).add_json("sessions", std::move(sessions));
  result.print(context);
  return failed ? kExitBadData : kExitDone;
}

/// What lies in a folder and may be a log: files, and folders that are recordings.
class WatchedFolder {
 public:
  WatchedFolder(std::string folder, double settled_s)
      : folder_(std::move(folder)), settled_(settled_s) {}

  /// Those that nobody has written to for a while and that were not given out before, by name.
  [[nodiscard]] std::vector<std::string> take_complete() {
    std::vector<std::string> complete;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
      const std::string path = entry.path().string();
      const bool may_be_log = entry.is_regular_file() || fs::exists(entry.path() / "metadata.yaml");
      if (!may_be_log || entry.path().filename().string().starts_with('.')) continue;
      const auto changed = newest_change(entry.path());
      const auto given = given_.find(path);
      if (given != given_.end() && given->second == changed) continue;
      if (fs::file_time_type::clock::now() - changed < std::chrono::duration<double>(settled_))
        continue;
      given_[path] = changed;
      complete.push_back(path);
    }
    std::ranges::sort(complete);
    return complete;
  }

 private:
  [[nodiscard]] static fs::file_time_type newest_change(const fs::path& path) {
    fs::file_time_type newest = fs::last_write_time(path);
    if (!fs::is_directory(path)) return newest;
    for (const fs::directory_entry& entry : fs::directory_iterator(path))
      newest = std::max(newest, entry.last_write_time());
    return newest;
  }

  fs::path folder_;
  double settled_;
  std::map<std::string, fs::file_time_type> given_{};
};

ExitCode watch(const Arguments& arguments, const AppContext& context) {
  const std::string& folder = arguments.logs.front();
  if (!fs::is_directory(folder)) throw DataError({folder}, "is no folder");
  make_site(arguments.site, context);
  WatchedFolder watched(folder, arguments.settled_s);
  const HeldInterrupt held("interrupted: the site stays as it is; once more ends it at once");
  context.note(folder + ": watched; Ctrl-C ends it");
  while (!interrupted()) {
    for (const std::string& log : watched.take_complete()) {
      if (interrupted()) break;
      try {
        Site site(arguments.site, SiteAccess::kWrite, context.threads());
        if (has_log(site, log)) continue;
        const Added added = add_log(site, log, arguments, context);
        Result result;
        add_row(added, result);
        if (context.json()) result.add_json("session", row_of(added));
        result.print(context);
      } catch (const std::runtime_error& error) {
        if (!interrupted()) context.warn(error.what());
      }
    }
    if (arguments.once) return kExitDone;
    constexpr auto kPause = std::chrono::milliseconds(500);
    if (!interrupted()) std::this_thread::sleep_for(kPause);
  }
  return kExitDone;
}

void add_watch_command(CLI::App& site, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      site.add_subcommand("watch", "Add each log of a folder to a site once it is complete");
  command->add_option("SITE", arguments->site, "its file; made where there is none")->required();
  command->add_option("FOLDER", arguments->logs, "where logs are put")->expected(1)->required();
  command
      ->add_option("--settled", arguments->settled_s,
                   "a log is complete when nobody has written to it for so long")
      ->type_name("SECONDS")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_flag("--once", arguments->once, "add what is complete now, and end");
  add_log_flags(*command, arguments->reading);
  context.add_common_flags(*command);
  context.add_threads_flag(*command);
  context.add_option_flags(*command);
  context.add_robot_flag(*command);
  context.on_run(*command, [arguments, &context] { return watch(*arguments, context); });
}

}  // namespace

void add_site_add_command(CLI::App& site, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = site.add_subcommand("add", "Map logs and join them to a site");
  command->add_option("SITE", arguments->site, "its file; made where there is none")->required();
  command
      ->add_option("LOG", arguments->logs,
                   "log files, or folders (DIR#20 names set 20 of a UCSD folder)")
      ->required();
  command
      ->add_option("--date", arguments->date,
                   "when the log was recorded, UTC (default: as its stamps say)")
      ->type_name("DATE");
  add_cut_flags(*command, arguments->cut);
  add_log_flags(*command, arguments->reading);
  context.add_common_flags(*command);
  context.add_threads_flag(*command);
  context.add_option_flags(*command);
  context.add_robot_flag(*command);
  command->footer(kFooter);
  context.on_run(*command, [arguments, &context] { return run(*arguments, context); });
  add_watch_command(site, context);
}

}  // namespace loopstone::app
