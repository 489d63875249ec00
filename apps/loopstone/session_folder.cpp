#include "session_folder.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/session_file.hpp"

namespace loopstone::app {

namespace {

namespace fs = std::filesystem;

constexpr const char* kSessionName = "session.loopstone";
constexpr const char* kStartAnew =
    "; to start from the beginning, leave out --resume and add --force";

std::string session_path(const std::string& out) { return (fs::path(out) / kSessionName).string(); }

bool exists(const std::string& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

std::string read_text(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Null when there is none.
nlohmann::json field(const nlohmann::json& summary, const char* key) {
  return summary.is_object() ? summary.value(key, nlohmann::json()) : nlohmann::json();
}

}  // namespace

void add_checkpoint_flags(CLI::App& command, CheckpointFlags& flags) {
  command
      .add_option("--checkpoint", flags.every_s,
                  "save the state of the run every SECONDS into OUT/session.loopstone, and on "
                  "Ctrl-C; --resume goes on from there")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.001, 1e9));
  command.add_flag("--resume", flags.resume,
                   "go on from the session in OUT to the same result as a run without a break; "
                   "from the beginning when there is none yet");
}

RunStart find_start(const std::string& out, const CheckpointFlags& flags, bool force) {
  if (exists(session_path(out))) {
    if (flags.resume) return RunStart::kSession;
    if (force) return RunStart::kLog;
    throw UsageError(out +
                     ": holds the session of a run that was ended before its time; add "
                     "--resume to go on with it, or --force to start from the beginning");
  }
  if (!flags.resume || force) return RunStart::kLog;
  return field(summary_of(out), "complete") == true ? RunStart::kResults : RunStart::kLog;
}

void remove_session(const std::string& out) {
  const std::string session = session_path(out);
  std::error_code error;
  fs::remove(session, error);
  if (error) throw DataError({session}, "cannot remove the old session: " + error.message());
}

RunInfo::Terms result_terms(const SessionTerms& terms, const std::string& colour,
                            const LogDigest& log) {
  return {{"log", log.text()},
          {"start_s", fmt::format("{}", terms.start_s)},
          {"duration_s", fmt::format("{}", terms.duration_s)},
          {"max_scans", fmt::format("{}", terms.max_scans)},
          {"mounts", terms.mounts_from_log ? "log" : "robot"},
          {"colour", colour},
          {"robot", terms.robot_toml}};
}

std::optional<std::string> find_results(const std::string& out, const SessionTerms& terms,
                                        const RunInfo::Terms& result) {
  const fs::path folder(out);
  const nlohmann::json summary = summary_of(out);
  const nlohmann::json expected(std::map<std::string, std::string>(result.begin(), result.end()));
  if (field(summary, "complete") != true || field(summary, "version") != terms.version ||
      field(summary, "result_of") != expected ||
      read_text((folder / "options.toml").string()) != terms.options_toml) {
    return std::nullopt;
  }
  return read_text((folder / "summary.json").string());
}

Checkpoint::How session_in(const std::string& out, const CheckpointFlags& flags,
                           const AppContext& context) {
  if (!flags.any()) return {};
  return {.every_s = flags.every_s,
          .write = [path = session_path(out)](
                       const Session& session) { return write_session(path, session); },
          .failed =
              [&context](const std::string& reason) {
                context.warn("the session could not be saved, the run goes on: " + reason);
              },
          .cpu_seconds = cpu_seconds};
}

void resume_from(const std::string& out, Checkpoint& checkpoint, Mapper& mapper, CutLog& log,
                 CameraFrames& camera, const AppContext& context) {
  const std::string path = session_path(out);
  try {
    checkpoint.resume(read_session(path, context.memory()), mapper, [&] {
      auto message = log.next();
      if (message) camera.take(*message);
      return message;
    });
  } catch (const UsageError& error) {
    throw std::runtime_error(path + ": " + error.what() + kStartAnew);
  } catch (const DataError& error) {
    throw std::runtime_error(std::string(error.what()) + kStartAnew);
  }
  context.note(fmt::format("goes on after {} scans of the session", mapper.scans()));
}

void add_continue_flags(CLI::App& command, ContinueFlags& flags) {
  command.add_flag("--keep-state", flags.keep_state,
                   "also OUT/state.loopstone, from which --continue goes on with the map");
  command
      .add_option("--continue", flags.from,
                  "go on with the map in this folder (made with --keep-state): LOG is another "
                  "drive in its building, which may begin anywhere in it; the folder stays as it "
                  "is")
      ->type_name("FOLDER");
}

nlohmann::json summary_of(const std::string& out) {
  nlohmann::json summary =
      nlohmann::json::parse(read_text((fs::path(out) / "summary.json").string()), nullptr, false);
  return summary.is_object() ? summary : nlohmann::json();
}

MapperState read_state(const std::string& out, const SessionTerms& now, const AppContext& context) {
  Session session = read_kept_state(out, "go on from", context.memory());
  SessionTerms then = now;
  then.options_toml = session.terms.options_toml;
  const std::string differs = difference(then, now);
  if (!differs.empty())
    throw DataError({kept_state_path(out)}, "is of another kind of run: " + differs);
  const nlohmann::json edits = field(summary_of(out), "edits");
  if (!edits.is_null()) {
    throw DataError({out}, "is a map that was edited; go on with the one that was not" +
                               (edits.contains("edited") && edits["edited"].is_string()
                                    ? " (" + edits["edited"].get<std::string>() + ")"
                                    : std::string()) +
                               ", then do the edits of its edits.toml to what comes of it");
  }
  return std::move(session.mapper);
}

void continue_from(const std::string& out, MapperState state, Mapper& mapper,
                   const AppContext& context) {
  try {
    mapper.restore_state(std::move(state));
  } catch (const UsageError& error) {
    throw DataError({kept_state_path(out)}, std::string("is damaged: ") + error.what());
  }
  mapper.begin_drive();
  context.note(fmt::format("{}: {} scans; another drive begins", out, mapper.scans()));
}

void end_session(const std::string& out, const CheckpointFlags& flags, const Checkpoint& checkpoint,
                 bool complete, const AppContext& context) {
  if (!flags.any()) return;
  const Checkpoint::Cost& cost = checkpoint.cost();
  if (cost.saved > 0) {
    context.note(
        fmt::format("session saved {} times, {:.1f} MB at last; scans waited for it {:.1f} ms each "
                    "time, {:.1f} ms at most",
                    cost.saved, 1e-6 * static_cast<double>(cost.bytes),
                    1e3 * cost.blocked_s / static_cast<double>(cost.saved), 1e3 * cost.longest_s));
  }
  if (!complete) return;
  const std::string path = session_path(out);
  std::error_code error;
  fs::remove(path, error);
  if (error) context.warn(path + ": cannot be removed: " + error.message());
}

}  // namespace loopstone::app
