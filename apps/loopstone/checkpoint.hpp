#pragma once

#include <chrono>
#include <cstdint>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "app.hpp"
#include "floor_run.hpp"
#include "log_run.hpp"
#include "loopstone/base/state_chunk.hpp"
#include "loopstone/formats/log_digest.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/slam/mapper.hpp"

// What lets a run go on after it was ended from outside: its state, saved now and then into a
// session file beside the results.

namespace loopstone::app {

struct CheckpointFlags {
  double every_s = 0.0;  ///< 0: not now and then
  bool resume = false;
  [[nodiscard]] bool any() const { return every_s > 0.0 || resume; }
};

/// --checkpoint, --resume.
void add_checkpoint_flags(CLI::App& command, CheckpointFlags& flags);

/// Where a run begins.
enum class RunStart {
  kLog,      ///< with the log
  kSession,  ///< with the session in the output folder
  kResults,  ///< there are complete results; if they are of this very run, there is nothing to do
};

/// By what is in the output folder; nothing is changed. Throws UsageError when it holds a session
/// that neither --resume nor `force` asks for.
[[nodiscard]] RunStart find_start(const std::string& out, const CheckpointFlags& flags, bool force);

/// An old session is not of the run that begins. Throws DataError when it can't be removed.
void remove_session(const std::string& out);

/// What a run has in common with the one whose session it goes on with; else it would not lead to
/// the same result.
struct RunTerms {
  std::string version;  ///< of Loopstone
  std::string options_toml;
  std::string robot_toml;
  bool mounts_from_log = true;
  LogCut cut{};

  template <typename Archive>
  void archive(Archive& a) {
    a(version, options_toml, robot_toml, mounts_from_log, cut.start_s, cut.duration_s,
      cut.max_scans);
  }
};

/// What determines the files of a run, with what `colour` says of the camera's part in them.
[[nodiscard]] RunInfo::Terms result_terms(const RunTerms& terms, const std::string& colour,
                                          const LogDigest& log);

/// The summary.json of the finished run in a folder when it has the same version, options and
/// terms; else nothing.
[[nodiscard]] std::optional<std::string> find_results(const std::string& out, const RunTerms& terms,
                                                      const RunInfo::Terms& result);

/// What differs, in words with both values; empty when nothing does.
[[nodiscard]] std::string difference(const RunTerms& session, const RunTerms& now);

/// Saves a run's state and puts it back. Without flags it does nothing.
class Checkpoint {
 public:
  Checkpoint(const CheckpointFlags& flags, const std::string& out, RunTerms terms,
             const AppContext& context);

  /// Reads the session, and the log up to where it was saved.
  /// Throws when the session is damaged, or not of this log, robot, options and program.
  void resume(Mapper& mapper, CutLog& log, CameraFrames& camera, const std::string& log_path);

  /// A message that the mapper has dealt with. Saves when it is time to, and the last time is over
  /// and done.
  void after(const SensorMessage& message, Mapper& mapper);
  /// Saves in any case, and returns when that is on disk: no more messages will come, be it the end
  /// or Ctrl-C.
  void after_last(Mapper& mapper);
  /// The results are written. Removes the session when they are complete.
  void end(bool complete);

  [[nodiscard]] const RunTerms& terms() const { return run_.terms; }
  /// Of all messages that the mapper has dealt with.
  [[nodiscard]] const LogDigest& log() const { return run_.log; }
  /// What runs before this one took for the same result.
  [[nodiscard]] double earlier_wall_s() const { return run_.wall_s; }
  [[nodiscard]] double earlier_cpu_s() const { return run_.cpu_s; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Run {
    RunTerms terms{};
    LogDigest log{};
    double wall_s = 0.0;
    double cpu_s = 0.0;

    template <typename Archive>
    void archive(Archive& a) {
      a(terms, log, wall_s, cpu_s);
    }
  };

  void save(Mapper& mapper);
  /// Hears how the last writing ended.
  void settle();
  [[nodiscard]] double now_s() const;

  CheckpointFlags flags_;
  std::string path_;
  const AppContext& context_;
  Run run_{};  ///< of the runs before this one, but for the log
  Clock::time_point started_ = Clock::now();
  double last_s_ = 0.0;
  std::future<std::int64_t> writing_{};  ///< bytes written
  bool warned_ = false;
  std::int64_t saved_ = 0;
  std::int64_t bytes_ = 0;
  double blocked_s_ = 0.0;
  double longest_s_ = 0.0;
};

}  // namespace loopstone::app
