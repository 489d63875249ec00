#include "loopstone/pipeline/cut_log.hpp"

#include <utility>
#include <variant>

#include "loopstone/base/error.hpp"

namespace loopstone {

CutLog::CutLog(LogReader& reader, const LogCut& cut, bool mounts_from_log, std::string_view step,
               ReadingWatch watch)
    : reader_(reader),
      analyser_(reader),
      cut_(cut),
      mounts_from_log_(mounts_from_log),
      step_(step),
      watch_(std::move(watch)) {}

std::optional<SensorMessage> CutLog::next() {
  while (!interrupted_) {
    if (cut_.max_scans > 0 && scans_ >= cut_.max_scans) return {};
    auto message = reader_.next();
    interrupted_ = watch_.stop && watch_.stop();
    if (!message) return {};
    analyser_.add(*message);
    if (!first_) first_ = stamp_of(*message);
    const double time_s = (stamp_of(*message) - *first_).seconds();
    if (cut_.duration_s > 0.0 && time_s > cut_.start_s + cut_.duration_s) return {};
    if (auto* scan = std::get_if<LaserScan>(&*message)) {
      if (time_s < cut_.start_s) continue;
      if (!mounts_from_log_) scan->robot_T_lidar.reset();
      ++scans_;
      const auto [done, total] = reader_.progress();
      const bool goes_on =
          !watch_.progress || watch_.progress({step_, done, total, scans_, time_s});
      interrupted_ = interrupted_ || !goes_on;
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

std::vector<std::string> warnings_of(const LogSummary& summary) {
  std::vector<std::string> warnings;
  for (const Finding& finding : summary.findings) {
    if (finding.severity == Severity::kWarning) warnings.push_back(finding.text);
  }
  return warnings;
}

}  // namespace loopstone
