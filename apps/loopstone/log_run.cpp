#include "log_run.hpp"

#include <sys/resource.h>

#include <variant>

#include "loopstone/base/error.hpp"
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

CutLog::CutLog(LogReader& reader, const LogCut& cut, bool mounts_from_log, std::string_view step,
               ProgressDisplay& display)
    : reader_(reader),
      cut_(cut),
      mounts_from_log_(mounts_from_log),
      step_(step),
      display_(display) {}

std::optional<SensorMessage> CutLog::next() {
  while (!interrupted_) {
    if (cut_.max_scans > 0 && scans_ >= cut_.max_scans) return {};
    auto message = reader_.next();
    if (!message) return {};
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

void CutLog::require_scans(const std::string& path) const {
  if (scans_ > 0 || interrupted_) return;
  throw DataError({path}, "there is no laser scan in it" +
                              std::string(cut_.start_s > 0.0 ? " after --start" : "") +
                              "; `loopstone info` shows what there is");
}

void ProblemPrinter::operator()(const Problem& problem) {
  constexpr int kShown = 5;
  ++count_;
  if (count_ <= kShown) context_.warn(to_string(problem.location) + ": " + problem.reason);
  if (count_ == kShown + 1) {
    context_.warn("more records were skipped; `loopstone info` tells what is wrong with a log");
  }
}

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

RunInfo run_info(const std::string& log_path, const LogReader& reader, bool force,
                 const AppContext& context) {
  RunInfo info;
  info.log_path = log_path;
  info.command_line = context.command_line();
  info.version = kVersion;
  info.threads = context.threads().resolved();
  info.force = force;
  info.records_skipped = reader.records_skipped();
  info.cpu_time_s = cpu_seconds();
  info.peak_memory_bytes = peak_memory_bytes();
  return info;
}

}  // namespace loopstone::app
