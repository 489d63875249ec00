#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "app.hpp"
#include "floor_run.hpp"
#include "log_run.hpp"
#include "loopstone/sensor/log_digest.hpp"
#include "loopstone/slam/checkpoint.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/slam/session.hpp"

// Where the session of a run lies: a file beside its results.

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

/// What determines the files of a run, with what `colour` says of the camera's part in them.
[[nodiscard]] RunInfo::Terms result_terms(const SessionTerms& terms, const std::string& colour,
                                          const LogDigest& log);

/// The summary.json of the finished run in a folder when it has the same version, options and
/// terms; else nothing.
[[nodiscard]] std::optional<std::string> find_results(const std::string& out,
                                                      const SessionTerms& terms,
                                                      const RunInfo::Terms& result);

/// How the flags ask for sessions in an output folder; without flags none is written.
[[nodiscard]] Checkpoint::How session_in(const std::string& out, const CheckpointFlags& flags,
                                         const AppContext& context);

/// Reads the session of an output folder, and the log up to where it was saved. Throws when the
/// session is damaged, or not of this log, robot, options and program.
void resume_from(const std::string& out, Checkpoint& checkpoint, Mapper& mapper, CutLog& log,
                 CameraFrames& camera, const AppContext& context);

/// --keep-state, --continue.
struct ContinueFlags {
  bool keep_state = false;
  std::string from{};  ///< a folder with a state
  [[nodiscard]] bool any() const { return keep_state || !from.empty(); }
};
void add_continue_flags(CLI::App& command, ContinueFlags& flags);

/// Throws DataError when the folder has none, it is damaged, of another version or of other
/// options, or of a map that was edited.
[[nodiscard]] MapperState read_state(const std::string& out, const SessionTerms& now,
                                     const AppContext& context);
/// The summary.json of a folder, null when there is none or it is no JSON.
[[nodiscard]] nlohmann::json summary_of(const std::string& out);
/// Gives a mapper that was just made the state of a folder, and begins another drive.
void continue_from(const std::string& out, MapperState state, Mapper& mapper,
                   const AppContext& context);

/// The results are written: says what saving cost, and removes the session when they are complete.
void end_session(const std::string& out, const CheckpointFlags& flags, const Checkpoint& checkpoint,
                 bool complete, const AppContext& context);

}  // namespace loopstone::app
