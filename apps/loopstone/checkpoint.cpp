#include "checkpoint.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/session_file.hpp"

namespace loopstone::app {

namespace {

namespace fs = std::filesystem;

constexpr const char* kSessionName = "session.loopstone";
constexpr const char* kRunTag = "RUN ";
/// Raised whenever the field list of Run or RunTerms changes.
constexpr std::uint16_t kRunVersion = 1;
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

nlohmann::json summary_in(const std::string& out) {
  return nlohmann::json::parse(read_text((fs::path(out) / "summary.json").string()), nullptr,
                               false);
}

/// Null when there is none.
nlohmann::json field(const nlohmann::json& summary, const char* key) {
  return summary.is_object() ? summary.value(key, nlohmann::json()) : nlohmann::json();
}

/// "front_end.points_max = 360" where two texts of the same keys first differ; empty where they
/// don't.
std::string differing_line(const std::string& was, const std::string& is) {
  std::istringstream old_lines(was);
  std::istringstream new_lines(is);
  std::string group;
  std::string before;
  std::string now;
  while (true) {
    const bool more_old = static_cast<bool>(std::getline(old_lines, before));
    const bool more_new = static_cast<bool>(std::getline(new_lines, now));
    if (!more_old && !more_new) return {};
    if (!more_old || !more_new) return "one has more than the other";
    if (before != now) return fmt::format("{}`{}` then, `{}` now", group, before, now);
    if (now.starts_with('[')) group = now + " ";
  }
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
  return field(summary_in(out), "complete") == true ? RunStart::kResults : RunStart::kLog;
}

void remove_session(const std::string& out) {
  const std::string session = session_path(out);
  std::error_code error;
  fs::remove(session, error);
  if (error) throw DataError({session}, "cannot remove the old session: " + error.message());
}

RunInfo::Terms result_terms(const RunTerms& terms, const std::string& colour,
                            const LogDigest& log) {
  return {{"log", log.text()},
          {"start_s", fmt::format("{}", terms.cut.start_s)},
          {"duration_s", fmt::format("{}", terms.cut.duration_s)},
          {"max_scans", fmt::format("{}", terms.cut.max_scans)},
          {"mounts", terms.mounts_from_log ? "log" : "robot"},
          {"colour", colour},
          {"robot", terms.robot_toml}};
}

std::optional<std::string> find_results(const std::string& out, const RunTerms& terms,
                                        const RunInfo::Terms& result) {
  const fs::path folder(out);
  const nlohmann::json summary = summary_in(out);
  const nlohmann::json expected(std::map<std::string, std::string>(result.begin(), result.end()));
  if (field(summary, "complete") != true || field(summary, "version") != terms.version ||
      field(summary, "result_of") != expected ||
      read_text((folder / "options.toml").string()) != terms.options_toml) {
    return std::nullopt;
  }
  return read_text((folder / "summary.json").string());
}

std::string difference(const RunTerms& session, const RunTerms& now) {
  const auto differs = [](const char* what, const auto& then, const auto& now_is) {
    return fmt::format("{}: {} then, {} now", what, then, now_is);
  };
  if (session.version != now.version) return differs("loopstone", session.version, now.version);
  std::string line = differing_line(session.options_toml, now.options_toml);
  if (!line.empty()) return "options: " + line;
  line = differing_line(session.robot_toml, now.robot_toml);
  if (!line.empty()) return "robot: " + line;
  if (session.mounts_from_log != now.mounts_from_log) {
    return differs("--robot", session.mounts_from_log ? "not given" : "given",
                   now.mounts_from_log ? "not given" : "given");
  }
  const LogCut& was = session.cut;
  if (was.start_s != now.cut.start_s) return differs("--start", was.start_s, now.cut.start_s);
  if (was.duration_s != now.cut.duration_s)
    return differs("--duration", was.duration_s, now.cut.duration_s);
  if (was.max_scans != now.cut.max_scans)
    return differs("--max-scans", was.max_scans, now.cut.max_scans);
  return {};
}

Checkpoint::Checkpoint(const CheckpointFlags& flags, const std::string& out, RunTerms terms,
                       const AppContext& context)
    : flags_(flags), path_(session_path(out)), context_(context) {
  run_.terms = std::move(terms);
}

double Checkpoint::now_s() const {
  return std::chrono::duration<double>(Clock::now() - started_).count();
}

void Checkpoint::resume(Mapper& mapper, CutLog& log, CameraFrames& camera,
                        const std::string& log_path) {
  Run saved;
  try {
    std::vector<StateChunk> chunks = read_session(path_, context_.memory());
    load_chunk(chunks, kRunTag, kRunVersion, saved);
    const std::string differs = difference(saved.terms, run_.terms);
    if (!differs.empty()) throw DataError({path_}, "is of another run: " + differs);
    std::erase_if(chunks, [](const StateChunk& chunk) { return chunk.tag == kRunTag; });
    mapper.restore_state(chunks);
    while (run_.log.messages() < saved.log.messages()) {
      const auto message = log.next();
      if (!message) break;
      run_.log.add(*message);
      camera.take(*message);
    }
    if (run_.log != saved.log) {
      throw DataError({path_}, "is of another log: the first " +
                                   std::to_string(saved.log.messages()) + " messages of " +
                                   log_path + " are not those that it was made of");
    }
  } catch (const DataError& error) {
    throw std::runtime_error(std::string(error.what()) + kStartAnew);
  }
  run_ = std::move(saved);
  context_.note(fmt::format("goes on after {} scans of the session", mapper.scans()));
}

void Checkpoint::after(const SensorMessage& message, Mapper& mapper) {
  run_.log.add(message);
  if (flags_.every_s <= 0.0 || now_s() - last_s_ < flags_.every_s) return;
  const bool busy =
      writing_.valid() && writing_.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
  if (!busy) save(mapper);
}

void Checkpoint::after_last(Mapper& mapper) {
  if (!flags_.any() || run_.log.messages() == 0) return;
  save(mapper);
  settle();
}

void Checkpoint::save(Mapper& mapper) {
  settle();
  last_s_ = now_s();
  Run run = run_;
  run.wall_s += last_s_;
  run.cpu_s += cpu_seconds();
  // The back end gives its part when it has come so far; the disk takes its time. Neither holds up
  // the next scan.
  writing_ =
      std::async(std::launch::async, [path = path_, head = save_chunk(kRunTag, kRunVersion, run),
                                      state = mapper.save_state()]() mutable {
        std::vector<StateChunk> chunks = state.get();
        chunks.insert(chunks.begin(), std::move(head));
        write_session(path, chunks);
        return std::transform_reduce(
            chunks.begin(), chunks.end(), std::int64_t{0}, std::plus<>(),
            [](const StateChunk& chunk) { return static_cast<std::int64_t>(chunk.bytes.size()); });
      });
  const double blocked_s = now_s() - last_s_;
  blocked_s_ += blocked_s;
  longest_s_ = std::max(longest_s_, blocked_s);
}

void Checkpoint::settle() {
  if (!writing_.valid()) return;
  try {
    bytes_ = writing_.get();
    ++saved_;
    warned_ = false;
  } catch (const std::future_error&) {
    // The back end failed before it came so far; it says so itself.
  } catch (const std::exception& error) {
    if (!warned_) {
      context_.warn(std::string("the session could not be saved, the run goes on: ") +
                    error.what());
    }
    warned_ = true;
  }
}

void Checkpoint::end(bool complete) {
  if (!flags_.any()) return;
  settle();
  if (saved_ > 0) {
    context_.note(
        fmt::format("session saved {} times, {:.1f} MB at last; scans waited for it {:.1f} ms each "
                    "time, {:.1f} ms at most",
                    saved_, 1e-6 * static_cast<double>(bytes_),
                    1e3 * blocked_s_ / static_cast<double>(saved_), 1e3 * longest_s_));
  }
  if (!complete) return;
  std::error_code error;
  fs::remove(path_, error);
  if (error) context_.warn(path_ + ": cannot be removed: " + error.message());
}

}  // namespace loopstone::app
