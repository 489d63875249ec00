#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "app.hpp"
#include "commands.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/report/map_outputs.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/slam/scan_to_scan.hpp"
#include "loopstone/version.hpp"
#include "progress_display.hpp"
#include "result.hpp"

namespace loopstone::app {

namespace {

struct Arguments {
  std::string log;
  std::string out;
  std::string pipeline = "submaps";
  double start_s = 0.0;
  double duration_s = 0.0;
  std::int64_t max_scans = 0;
  bool no_loop_closure = false;
  bool force = false;
  bool strict = false;
};

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::int64_t peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
}

/// The messages of a log between --start and --duration, at most --max-scans
/// scans, until the user interrupts.
class CutLog {
 public:
  CutLog(LogReader& reader, const Arguments& arguments, bool mounts_from_log,
         ProgressDisplay& display)
      : reader_(reader),
        arguments_(arguments),
        mounts_from_log_(mounts_from_log),
        display_(display) {}

  [[nodiscard]] std::optional<SensorMessage> next() {
    while (!interrupted_) {
      if (arguments_.max_scans > 0 && scans_ >= arguments_.max_scans) return {};
      auto message = reader_.next();
      if (!message) return {};
      if (!first_) first_ = stamp_of(*message);
      const double time_s = (stamp_of(*message) - *first_).seconds();
      if (arguments_.duration_s > 0.0 && time_s > arguments_.start_s + arguments_.duration_s)
        return {};
      if (auto* scan = std::get_if<LaserScan>(&*message)) {
        if (time_s < arguments_.start_s) continue;
        if (!mounts_from_log_) scan->robot_T_lidar.reset();
        ++scans_;
        const auto progress = reader_.progress();
        interrupted_ =
            !display_.show({"mapping", progress.bytes_done, progress.bytes_total, scans_, time_s});
      }
      return message;
    }
    return {};
  }
  [[nodiscard]] bool interrupted() const { return interrupted_; }
  [[nodiscard]] std::int64_t scans() const { return scans_; }

 private:
  LogReader& reader_;
  const Arguments& arguments_;
  bool mounts_from_log_;
  ProgressDisplay& display_;
  std::optional<Stamp> first_{};
  std::int64_t scans_ = 0;
  bool interrupted_ = false;
};

void print_result(const MapResult& result, const RunInfo& info, const std::string& out,
                  const AppContext& context) {
  const std::string summary = format_summary(result, info);
  if (context.json()) {
    print_to_stdout(summary);
    return;
  }
  const MapStatistics& s = result.statistics;
  const double free_m2 = nlohmann::json::parse(summary).at("map_free_area_m2").get<double>();
  Result table;
  table.add("scans", "scans", s.scans);
  if (info.records_skipped > 0)
    table.add("records_skipped", "records skipped", info.records_skipped);
  table.add("duration_s", "recording", s.duration_s, "s", 1);
  table.add("path_length_m", "path", s.path_length_m, "m", 1);
  table.add("map_free_area_m2", "free area mapped", free_m2, "m2", 1);
  table.add("submaps", "submaps", s.submaps);
  table.add_row("loop closures", fmt::format("{} accepted, {} rejected", s.loop_closures_accepted,
                                             s.loop_closures_rejected));
  table.add_row("time", fmt::format("{:.2f} s, {:.0f} x real time", info.wall_time_s,
                                    s.duration_s / std::max(info.wall_time_s, 1e-9)));
  table.add_row("peak memory",
                fmt::format("{:.0f}", static_cast<double>(info.peak_memory_bytes) * 1e-6), "MB");
  table.add_row("report", out + "/report.html");
  table.print(context);
}

/// Warns of the first few records that were skipped; the rest is a number in the summary.
class ProblemPrinter {
 public:
  explicit ProblemPrinter(const AppContext& context) : context_(context) {}

  void operator()(const Problem& problem) {
    constexpr int kShown = 5;
    ++count_;
    if (count_ <= kShown) context_.warn(to_string(problem.location) + ": " + problem.reason);
    if (count_ == kShown + 1) {
      context_.warn("more records were skipped; `loopstone info` tells what is wrong with a log");
    }
  }

 private:
  const AppContext& context_;
  int count_ = 0;
};

ExitCode run_map(const Arguments& arguments, const AppContext& context) {
  const auto start = std::chrono::steady_clock::now();
  const bool textbook = arguments.pipeline == "scan_to_scan";
  auto options = textbook ? MapOptions{} : context.load_options<MapOptions>();
  auto textbook_options =
      textbook ? context.load_options<ScanToScanOptions>() : ScanToScanOptions{};
  if (arguments.no_loop_closure) options.loop_closure = false;

  ProblemPrinter print_problem(context);
  const auto reader = open_log(
      arguments.log, {.strict = arguments.strict,
                      .on_problem = [&](const Problem& problem) { print_problem(problem); }});
  prepare_output_folder(arguments.out, arguments.force);
  const RobotModel robot = context.robot_given() ? context.robot() : reader->robot(context.robot());

  ProgressDisplay display(context);
  CutLog log(*reader, arguments, !context.robot_given(), display);
  MapResult result;
  if (textbook) {
    ScanToScanMapper mapper(robot, textbook_options, context.threads());
    while (const auto message = log.next()) mapper.add(*message);
    result = mapper.finish(display.callback());
  } else {
    Mapper mapper(robot, options, context.threads());
    while (const auto message = log.next()) mapper.add(*message);
    result = mapper.finish();
  }
  ProgressDisplay::clear_line();
  if (log.scans() == 0) {
    throw DataError({arguments.log},
                    "there is no laser scan in it" +
                        std::string(arguments.start_s > 0.0 ? " after --start" : "") +
                        "; `loopstone info` shows what there is");
  }
  result.complete = result.complete && !log.interrupted();

  RunInfo info;
  info.log_path = arguments.log;
  info.command_line = context.command_line();
  info.threads = context.threads().resolved();
  info.force = arguments.force;
  info.version = kVersion;
  info.options_toml =
      options_to_toml(textbook ? list_options(textbook_options) : list_options(options));
  info.records_skipped = reader->records_skipped();
  info.wall_time_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  info.cpu_time_s = cpu_seconds();
  info.peak_memory_bytes = peak_memory_bytes();
  write_map_outputs(result, info, arguments.out);

  for (const auto& warning : result.warnings) context.warn(warning);
  print_result(result, info, arguments.out, context);
  if (!result.complete) {
    context.warn("interrupted: the map is of what was read until then");
    return kExitInterrupted;
  }
  return kExitDone;
}

}  // namespace

void add_map_command(CLI::App& app, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("map", "Turn a log into a trajectory, a map and a report");
  command
      ->add_option("LOG", arguments->log,
                   "a log file, or a folder (DIR#20 names set 20 of a UCSD folder)")
      ->required();
  command
      ->add_option("-o,--out", arguments->out,
                   "folder for the results; made, or empty unless --force")
      ->required();
  command
      ->add_option("--pipeline", arguments->pipeline,
                   "submaps, or the textbook's scan_to_scan to compare with")
      ->check(CLI::IsMember({"submaps", "scan_to_scan"}))
      ->capture_default_str();
  command->add_option("--start", arguments->start_s, "skip scans before this time [s]")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--duration", arguments->duration_s, "use this much of the log [s]; 0 = all")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--max-scans", arguments->max_scans, "use this many scans; 0 = all")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--no-loop-closure", arguments->no_loop_closure,
                    "do not correct the map where places are seen again");
  command->add_flag("--strict", arguments->strict, "a broken record is an error, not skipped");
  command->add_flag("--force", arguments->force, "write into a folder that is not empty");
  context.add_common_flags(*command);
  context.add_threads_flag(*command);
  context.add_option_flags(*command);
  context.add_robot_flag(*command);
  context.on_run(*command, [arguments, &context] { return run_map(*arguments, context); });
}

}  // namespace loopstone::app
