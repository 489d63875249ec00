#include "log_run.hpp"

#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <utility>

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

ReadingWatch watch_by(ProgressDisplay& display) {
  return {.stop = app::interrupted, .progress = display.callback()};
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

LogSource source_of(const std::string& path, LogOptions how, const AppContext& context) {
  LogSource source{.path = path, .how = std::move(how)};
  if (context.robot_given()) source.robot = context.robot();
  return source;
}

RobotModel robot_of(const LogReader& log, const AppContext& context) {
  return source_of({}, {}, context).robot_of(log);
}

void judge_left_out(const LeftOut& left_out, const std::string& path, const AppContext& context,
                    Severity told) {
  const auto finding = loopstone::judge(left_out, path);
  if (!finding || finding->severity < told) return;
  if (finding->severity == Severity::kNote) return context.note(finding->text);
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
