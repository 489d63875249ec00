#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app.hpp"
#include "log_flags.hpp"
#include "loopstone/formats/log_files.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/log_summary.hpp"
#include "loopstone/report/run_info.hpp"
#include "progress_display.hpp"

// What the commands share that drive a log through the library: which part of it, its problems,
// what the run cost.

namespace loopstone::app {

/// The part of a log that is used.
struct LogCut {
  double start_s = 0.0;        ///< scans before are skipped
  double duration_s = 0.0;     ///< 0: to the end
  std::int64_t max_scans = 0;  ///< 0: all
};

/// --start, --duration, --max-scans.
void add_cut_flags(CLI::App& command, LogCut& cut);

/// --format: one of those that logs are written in.
void add_format_flag(CLI::App& command, std::optional<std::string>& format,
                     const std::string& meaning);

/// Read ahead by a thread of its own, where there may be several.
[[nodiscard]] std::unique_ptr<LogReader> open_with_threads(const std::string& path,
                                                           const LogOptions& how,
                                                           const AppContext& context);

/// The messages of a log within the cut, until the user interrupts.
class CutLog {
 public:
  /// \param step             what the progress line calls the work
  /// \param mounts_from_log  what scans say of their laser's place on the robot counts
  CutLog(LogReader& reader, const LogCut& cut, bool mounts_from_log, std::string_view step,
         ProgressDisplay& display);

  [[nodiscard]] std::optional<SensorMessage> next();
  [[nodiscard]] bool interrupted() const { return interrupted_; }
  [[nodiscard]] std::int64_t scans() const { return scans_; }
  /// What `loopstone info` says of the log, as far as it was read; when all is read. Throws
  /// DataError with its reasons when nothing can be made of it, unless the user interrupted.
  [[nodiscard]] LogSummary judge(const std::string& path);

 private:
  LogReader& reader_;
  LogAnalyser analyser_;
  LogCut cut_;
  bool mounts_from_log_;
  std::string_view step_;
  ProgressDisplay& display_;
  std::optional<Stamp> first_{};
  std::int64_t scans_ = 0;
  bool interrupted_ = false;
};

/// Warns of the first few records that were skipped; the rest is a number in the summary.
class ProblemPrinter {
 public:
  explicit ProblemPrinter(const AppContext& context) : context_(context) {}
  void operator()(const Problem& problem);

 private:
  const AppContext& context_;
  int count_ = 0;
};

/// Says what became of a log's files while they were read.
void warn_of_changes(const LogFiles& files, const AppContext& context);

/// How logs are read for this user: problems are warned of by `printer` when there is one, and
/// Ctrl-C ends the reading. Throws UsageError.
[[nodiscard]] LogOptions log_options(const LogFlags& flags, const AppContext& context,
                                     ProblemPrinter* printer = nullptr);

/// The robot of --robot, else what the log states of it; its wheels as the log's are to be read.
[[nodiscard]] RobotModel robot_of(const LogReader& log, const AppContext& context);

/// The texts of the findings that are warnings.
[[nodiscard]] std::vector<std::string> warnings_of(const LogSummary& summary);

/// Of commands that need no map: warns of what was left out of the log when it is as bad as `told`
/// at least. Throws DataError when hardly anything was used.
void judge_left_out(const LeftOut& left_out, const std::string& path, const AppContext& context,
                    Severity told = Severity::kWarning);

/// Of this process, all threads.
[[nodiscard]] double cpu_seconds();

/// What is known of every run when it is over; its options and wall time are the command's to say.
[[nodiscard]] RunInfo run_info(const std::string& log_path, const LeftOut& left_out, bool force,
                               const AppContext& context);

}  // namespace loopstone::app
