#include "loopstone/formats/log_summary.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <utility>

#include "formats/camera_collector.hpp"
#include "formats/log_findings.hpp"
#include "formats/timing_collector.hpp"
#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/base/median.hpp"

namespace loopstone {
namespace {

constexpr std::size_t kRangeBins = 20'000;  // of 1 cm
constexpr std::array<double, 5> kPercentiles{0.05, 0.25, 0.50, 0.75, 0.95};

class LidarCollector {
 public:
  explicit LidarCollector(int lidar) : bins_(kRangeBins + 1) { summary_.lidar = lidar; }

  void add(const LaserScan& scan) {
    timing_.add(scan.stamp);
    add_layout(scan);
    summary_.range_min_m = scan.range_min_m;
    summary_.range_max_m = scan.range_max_m;
    summary_.time_increment_s = scan.time_increment_s;
    if (scan.robot_T_lidar) summary_.robot_T_lidar = scan.robot_T_lidar;
    for (const float range_m : scan.ranges_m) add_range(range_m, scan);
    const bool repeats =
        scan.ranges_m.size() == last_.size() && !last_.empty() &&
        std::memcmp(scan.ranges_m.data(), last_.data(), last_.size() * sizeof(float)) == 0;
    if (repeats) ++summary_.repeated_scans;
    last_ = scan.ranges_m;
  }

  LidarSummary finish() {
    summary_.timing = timing_.finish();
    std::stable_sort(summary_.layouts.begin(), summary_.layouts.end(),
                     [](const BeamLayout& a, const BeamLayout& b) { return a.scans > b.scans; });
    if (summary_.ranges.returns > 0) {
      summary_.range_percentiles_m.front() = smallest_m_;
      summary_.range_percentiles_m.back() = largest_m_;
      for (std::size_t i = 0; i < kPercentiles.size(); ++i) {
        summary_.range_percentiles_m[i + 1] = percentile(kPercentiles[i]);
      }
    }
    return std::move(summary_);
  }

 private:
  void add_layout(const LaserScan& scan) {
    for (BeamLayout& layout : summary_.layouts) {
      if (layout.beams == scan.ranges_m.size() && layout.angle_min_rad == scan.angle_min_rad &&
          layout.angle_increment_rad == scan.angle_increment_rad) {
        ++layout.scans;
        return;
      }
    }
    if (summary_.layouts.size() < 100) {
      summary_.layouts.push_back(
          {scan.ranges_m.size(), scan.angle_min_rad, scan.angle_increment_rad, 1});
    }
  }

  void add_range(float range_m, const LaserScan& scan) {
    RangeClasses& classes = summary_.ranges;
    const auto value_m = static_cast<double>(range_m);
    if (std::isnan(range_m)) {
      ++classes.bad;
    } else if (std::isinf(range_m)) {
      ++classes.no_return;
    } else if (value_m < scan.range_min_m) {
      ++classes.too_near;
    } else if (value_m > scan.range_max_m) {
      ++classes.too_far;
    } else {
      ++classes.returns;
      ++bins_[static_cast<std::size_t>(
          std::clamp(std::lround(value_m * 100.0), 0L, static_cast<long>(kRangeBins)))];
      // ilogb rounds down: -1 for [0.5, 1), 0 for [1, 2), ...
      const int octave = value_m < 0.5 ? 0 : std::min(std::ilogb(value_m) + 2, 7);
      ++summary_.range_histogram[static_cast<std::size_t>(octave)];
      smallest_m_ = std::min(smallest_m_, value_m);
      largest_m_ = std::max(largest_m_, value_m);
    }
  }

  double percentile(double share) const {
    const double wanted = share * static_cast<double>(summary_.ranges.returns);
    double seen = 0.0;
    for (std::size_t bin = 0; bin < bins_.size(); ++bin) {
      seen += static_cast<double>(bins_[bin]);
      if (seen >= wanted) return static_cast<double>(bin) / 100.0;
    }
    return largest_m_;
  }

  LidarSummary summary_;
  TimingCollector timing_;
  std::vector<std::int64_t> bins_;
  std::vector<float> last_;
  double smallest_m_ = std::numeric_limits<double>::infinity();
  double largest_m_ = 0.0;
};

class OdometryCollector {
 public:
  void add(const OdometryPose& odometry) {
    timing_.add(odometry.stamp);
    if (last_) {
      const Pose2 step = last_->odom_T_robot.inverse() * odometry.odom_T_robot;
      const double length_m = hypotenuse(step.x, step.y);
      const double interval_s = (odometry.stamp - last_->stamp).seconds();
      summary_.path_length_m += length_m;
      summary_.turned_rad += std::abs(step.yaw);
      summary_.largest_step_m = std::max(summary_.largest_step_m, length_m);
      if (length_m > 0.5 && length_m > 10.0 * interval_s) ++summary_.jumps;
    }
    last_ = odometry;
  }
  OdometrySummary finish() {
    summary_.timing = timing_.finish();
    return summary_;
  }

 private:
  OdometrySummary summary_;
  TimingCollector timing_;
  std::optional<OdometryPose> last_;
};

class WheelCollector {
 public:
  void add(const WheelTicks& ticks) {
    timing_.add(ticks.stamp);
    for (std::size_t wheel = 0; wheel < 4; ++wheel) {
      summary_.travelled_counts[wheel] += std::abs(ticks.counts[wheel]);
    }
  }
  WheelSummary finish() {
    summary_.timing = timing_.finish();
    return summary_;
  }

 private:
  WheelSummary summary_;
  TimingCollector timing_;
};

class ImuCollector {
 public:
  void add(const ImuSample& sample) {
    timing_.add(sample.stamp);
    const Eigen::Vector3d& acceleration = sample.linear_acceleration_m_s2;
    const double length = acceleration.norm();
    if (length > 0.0) along_z_ += acceleration.z() / length;
    if (lengths_.size() >= TimingCollector::kMostIntervals) return;
    lengths_.push_back(static_cast<float>(length));
    yaw_rates_.push_back(static_cast<float>(sample.angular_velocity_rad_s.z()));
  }
  ImuSummary finish() {
    ImuSummary summary;
    summary.timing = timing_.finish();
    summary.gravity_along_z = along_z_ / static_cast<double>(summary.timing.records);
    summary.median_acceleration_m_s2 = static_cast<double>(median_of(lengths_));
    summary.median_yaw_rate_rad_s = static_cast<double>(median_of(yaw_rates_));
    return summary;
  }

 private:
  TimingCollector timing_;
  double along_z_ = 0.0;
  std::vector<float> lengths_;
  std::vector<float> yaw_rates_;
};

struct Collectors {
  std::map<int, LidarCollector> lidars{};
  std::optional<OdometryCollector> odometry{};
  std::optional<WheelCollector> wheels{};
  std::optional<ImuCollector> imu{};
  std::optional<CameraCollector> camera{};

  void add(const LaserScan& scan) {
    lidars.try_emplace(scan.lidar, scan.lidar).first->second.add(scan);
  }
  void add(const OdometryPose& pose) { made(odometry).add(pose); }
  void add(const WheelTicks& ticks) { made(wheels).add(ticks); }
  void add(const ImuSample& sample) { made(imu).add(sample); }
  void add(const RgbdFrame& frame) { made(camera).add(frame); }

 private:
  template <typename Collector>
  static Collector& made(std::optional<Collector>& collector) {
    if (!collector) collector.emplace();
    return *collector;
  }
};

}  // namespace

double BeamLayout::field_of_view_rad() const {
  return beams < 2 ? 0.0 : std::abs(angle_increment_rad) * static_cast<double>(beams - 1);
}

void LeftOutCounter::add(const SensorMessage& message) {
  last_ = stamp_of(message);
  if (!first_) first_ = last_;
  ++counts_.records_read;
  if (std::holds_alternative<LaserScan>(message)) ++counts_.scans_read;
  if (!counts_.since_s && log_->records_skipped() > 0) counts_.since_s = since_start_s();
}

double LeftOutCounter::since_start_s() const { return first_ ? (last_ - *first_).seconds() : 0.0; }

LeftOut LeftOutCounter::left_out() const {
  LeftOut result = counts_;
  result.skipped = log_->skipped();
  if (!result.since_s && result.skipped.records > 0) result.since_s = since_start_s();
  return result;
}

struct LogAnalyser::Impl {
  explicit Impl(const LogReader& reader) : log(reader), counter(reader) {}

  const LogReader& log;
  LogSummary summary{};
  Collectors collectors{};
  LeftOutCounter counter;
};

LogAnalyser::LogAnalyser(const LogReader& log) : impl_(std::make_unique<Impl>(log)) {}
LogAnalyser::~LogAnalyser() = default;
LogAnalyser::LogAnalyser(LogAnalyser&&) noexcept = default;
LogAnalyser& LogAnalyser::operator=(LogAnalyser&&) noexcept = default;

void LogAnalyser::add(const SensorMessage& message) {
  LogSummary& summary = impl_->summary;
  const Stamp stamp = stamp_of(message);
  summary.first = summary.first ? std::min(*summary.first, stamp) : stamp;
  summary.last = summary.last ? std::max(*summary.last, stamp) : stamp;
  impl_->counter.add(message);
  std::visit([&](const auto& reading) { impl_->collectors.add(reading); }, message);
}

LogSummary LogAnalyser::finish() {
  LogSummary summary = std::move(impl_->summary);
  const LogReader& log = impl_->log;
  Collectors& collectors = impl_->collectors;
  const ReadProgress read = log.progress();
  summary.format = log.format();
  summary.bytes = std::max(read.bytes_done, read.bytes_total);  // of a pipe no total is known
  summary.left_out = impl_->counter.left_out();
  for (auto& [lidar, collector] : collectors.lidars) summary.lidars.push_back(collector.finish());
  if (collectors.odometry) summary.odometry = collectors.odometry->finish();
  if (collectors.wheels) summary.wheels = collectors.wheels->finish();
  if (collectors.imu) summary.imu = collectors.imu->finish();
  if (collectors.camera) {
    summary.camera = collectors.camera->finish(log.pictures().get());
  }
  summary.topics = log.topics();
  summary.choices = log.choices();
  summary.findings = find_suspicious(summary, log.notes(), log.warnings());
  return summary;
}

LogSummary analyse_log(LogReader& log, const ProgressCallback& progress) {
  LogAnalyser analyser(log);
  std::int64_t scans = 0;
  std::int64_t messages = 0;
  const auto go_on = [&] {
    const ReadProgress read = log.progress();
    return !progress || progress({"reading", read.bytes_done, read.bytes_total, scans});
  };
  bool complete = true;
  while (complete) {
    const auto message = log.next();
    if (!message) {
      complete = go_on();  // the log may have ended because it was told to
      break;
    }
    analyser.add(*message);
    if (std::holds_alternative<LaserScan>(*message)) ++scans;
    if (++messages % 256 == 0) complete = go_on();
  }
  LogSummary summary = analyser.finish();
  summary.complete = complete;
  return summary;
}

}  // namespace loopstone
