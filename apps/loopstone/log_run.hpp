#pragma once

#include <optional>
#include <string>

#include "app.hpp"
#include "log_flags.hpp"
#include "loopstone/formats/log_files.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/log_summary.hpp"
#include "loopstone/pipeline/cut_log.hpp"
#include "loopstone/pipeline/log_source.hpp"
#include "loopstone/report/run_info.hpp"
#include "progress_display.hpp"

// What the commands share that drive a log through the library: how it is read for this user, its
// problems, what the run cost.

namespace loopstone::app {

/// --start, --duration, --max-scans.
void add_cut_flags(CLI::App& command, LogCut& cut);

/// --format: one of those that logs are written in.
void add_format_flag(CLI::App& command, std::optional<std::string>& format,
                     const std::string& meaning);

/// Who reads is shown to the user, and ends with Ctrl-C. Valid as long as the display.
[[nodiscard]] ReadingWatch watch_by(ProgressDisplay& display);

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

/// A log as this user has it read: with the robot of --robot, where there is one.
[[nodiscard]] LogSource source_of(const std::string& path, LogOptions how,
                                  const AppContext& context);

/// The robot of --robot, else what the log states of it; its wheels as the log's are to be read.
[[nodiscard]] RobotModel robot_of(const LogReader& log, const AppContext& context);

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
