#include "log_run.hpp"

#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <utility>
#include <variant>

#include "interrupt.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_format_words.hpp"
#include "loopstone/report/peak_memory.hpp"
#include "loopstone/version.hpp"

namespace loopstone::app {

void add_cut_flags(CLI::App& command, LogCut& cut) {
  command.add_option("--start", cut.start_s, "skip scans before this time [s]")
      ->check(CLI::NonNegativeNumber);
  command.add_option("--duration", cut.duration_s, "use this much of the log [s]; 0 = all")
      ->check(CLI::NonNegativeNumber);
  command.add_option("--max-scans", cut.max_scans, "use this many scans; 0 = all")
      ->check(CLI::NonNegativeNumber);
}

void add_format_flag(CLI::App& command, std::optional<std::string>& format,
                     const std::string& meaning) {
  const std::vector<std::string> names = writable_log_formats();
  std::string choice;
  for (const std::string& name : names) choice += (choice.empty() ? "" : "|") + name;
  command.add_option("--format", format, meaning)->type_name(choice)->check(CLI::IsMember(names));
}

std::unique_ptr<LogReader> open_with_threads(const std::string& path, const LogOptions& how,
                                             const AppContext& context) {
  return context.threads().resolved() > 1 ? open_log_ahead(path, how) : open_log(path, how);
}

CutLog::CutLog(LogReader& reader, const LogCut& cut, bool mounts_from_log, std::string_view step,
               ProgressDisplay& display)
    : reader_(reader),
      analyser_(reader),
      cut_(cut),
      mounts_from_log_(mounts_from_log),
      step_(step),
      display_(display) {}

std::optional<SensorMessage> CutLog::next() {
  while (!interrupted_) {
    if (cut_.max_scans > 0 && scans_ >= cut_.max_scans) return {};
    auto message = reader_.next();
    interrupted_ = app::interrupted();
    if (!message) return {};
    analyser_.add(*message);
    if (!first_) first_ = stamp_of(*message);
    const double time_s = (stamp_of(*message) - *first_).seconds();
    if (cut_.duration_s > 0.0 && time_s > cut_.start_s + cut_.duration_s) return {};
    if (auto* scan = std::get_if<LaserScan>(&*message)) {
      if (time_s < cut_.start_s) continue;
      if (!mounts_from_log_) scan->robot_T_lidar.reset();
      ++scans_;
      const auto progress = reader_.progress();
      interrupted_ =
          !display_.show({step_, progress.bytes_done, progress.bytes_total, scans_, time_s});
    }
    return message;
  }
  return {};
}

LogSummary CutLog::judge(const std::string& path) {
  LogSummary summary = analyser_.finish();
  if (interrupted_) return summary;
  std::string reasons;
  for (const Finding& finding : summary.findings) {
    if (finding.severity == Severity::kError)
      reasons += (reasons.empty() ? "" : "; ") + finding.text;
  }
  if (!reasons.empty()) throw DataError({path}, "nothing can be made of this log: " + reasons);
  if (scans_ == 0) {
    throw DataError(
        {path},
        "there is no laser scan in it after --start; `loopstone info` shows how long it is");
  }
  return summary;
}

LogOptions log_options(const LogFlags& flags, const AppContext& context, ProblemPrinter* printer) {
  LogOptions options{.strict = flags.strict,
                     .stamps = flags.stamps,
                     .memory = context.memory(),
                     .stop = app::interrupted,
                     .topics = topic_options(flags)};
  options.topics.wheels = context.stated_wheels();
  if (printer != nullptr) {
    options.on_problem = [printer](const LogProblem& problem) { (*printer)(problem); };
  }
  return options;
}

RobotModel robot_of(const LogReader& log, const AppContext& context) {
  RobotModel robot = context.robot();
  if (!context.robot_given()) return log.robot(std::move(robot));
  robot.wheels = log.wheels(robot.wheels);
  return robot;
}

std::vector<std::string> warnings_of(const LogSummary& summary) {
  std::vector<std::string> warnings;
  for (const Finding& finding : summary.findings) {
    if (finding.severity == Severity::kWarning) warnings.push_back(finding.text);
  }
  return warnings;
}

void judge_left_out(const LeftOut& left_out, const std::string& path, const AppContext& context,
                    Severity told) {
  const auto finding = loopstone::judge(left_out);
  if (!finding || finding->severity < told) return;
  if (finding->severity == Severity::kError) {
    throw DataError({path}, "nothing can be made of this log: " + finding->text);
  }
  context.warn(finding->text);
}

void ProblemPrinter::operator()(const Problem& problem) {
  constexpr int kShown = 5;
  ++count_;
  if (count_ <= kShown) context_.warn(to_string(problem.location) + ": " + problem.reason);
  if (count_ == kShown + 1) {
    context_.warn("more records were skipped; `loopstone info` tells what is wrong with a log");
  }
}

void warn_of_changes(const LogFiles& files, const AppContext& context) {
  for (const std::string& change : files.changes()) context.warn(change);
}

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

RunInfo run_info(const std::string& log_path, const LeftOut& left_out, bool force,
                 const AppContext& context) {
  RunInfo info;
  info.log_path = log_path;
  info.command_line = context.command_line();
  info.version = kVersion;
  info.threads = context.threads().resolved();
  info.force = force;
  info.left_out = left_out;
  info.cpu_time_s = cpu_seconds();
  info.peak_memory_bytes = peak_memory_bytes();
  return info;
}

}  // namespace loopstone::app
