#include "loopstone/odometry/scan_queue.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/base/sound_state.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

constexpr Duration kPatience = Duration::from_milliseconds(kScanQueue.patience_ms);
constexpr Duration kSilentStart = Duration::from_milliseconds(kScanQueue.silent_start_ms);
constexpr Duration kSilenceOfIncrements =
    Duration::from_milliseconds(kScanQueue.silence_of_increments_ms);
constexpr Duration kShortSilenceOfIncrements =
    Duration::from_milliseconds(kScanQueue.short_silence_of_increments_ms);
constexpr Duration kMostShift = Duration::from_milliseconds(kScanQueue.most_shift_ms);
constexpr Duration kSilenceOfSums = Duration::from_milliseconds(kScanQueue.silence_of_sums_ms);

}  // namespace

void ScanQueue::add(const SensorMessage& message) {
  own_.newest = stamp_of(message);
  if (!own_.first) own_.first = own_.newest;
  if (const auto* scan = std::get_if<LaserScan>(&message)) {
    own_.waiting.push_back(*scan);
  } else if (const auto* ticks = std::get_if<WheelTicks>(&message)) {
    odometer_.add(*ticks);
    own_.increments = !counts_are_cumulative_;
  } else if (const auto* imu = std::get_if<ImuSample>(&message)) {
    odometer_.add(*imu);
    gyro_.add(*imu);
  } else if (const auto* pose = std::get_if<OdometryPose>(&message)) {
    odometer_.add(*pose);
  }
  follow_odometry();
}

void ScanQueue::follow_odometry() {
  const auto newest = odometer_.newest();
  if (!newest || (own_.travel.stamp && *newest <= *own_.travel.stamp)) return;
  const Pose2 odom_T_robot = odometer_.pose_at(*newest)->pose;
  if (own_.travel.stamp) {
    const Pose2 step = own_.travel.odom_T_robot.inverse() * odom_T_robot;
    own_.travel.path_m += hypotenuse(step.x, step.y);
    own_.travel.turned_rad += std::abs(step.yaw);
    if (*newest - *own_.travel.stamp > longest_step()) own_.travel.silent_until = *newest;
  }
  own_.travel.stamp = newest;
  own_.travel.odom_T_robot = odom_T_robot;
}

/// From one reading to the next; after more, motion is missing in between.
Duration ScanQueue::longest_step() const {
  if (!own_.increments) return kSilenceOfSums;
  const std::int64_t readings = odometer_.turned_by_gyro() + odometer_.turned_by_wheels();
  if (readings < kScanQueue.readings_to_know) return kSilenceOfIncrements;
  const double usual_s = (own_.newest - *own_.first).seconds() / static_cast<double>(readings);
  return std::clamp(Duration::from_seconds(kScanQueue.silence_steps * usual_s),
                    kShortSilenceOfIncrements, kSilenceOfIncrements);
}

void ScanQueue::finish() {
  odometer_.finish();
  own_.finished = true;
}

std::optional<LaserScan> ScanQueue::next() {
  if (own_.waiting.empty()) return {};
  const Stamp stamp = own_.waiting.front().stamp;
  const Duration shift = shift_at(stamp);
  auto known_until = odometer_.newest();
  if (!known_until) known_until = gyro_.newest();
  const bool known = known_until && *known_until >= stamp + shift;
  const bool may_come = known_until || own_.newest - *own_.first <= kSilentStart;
  const Duration patience = kPatience + std::max(shift, Duration{});
  if (!known && may_come && !own_.finished && own_.newest - stamp < patience) return {};
  own_.shift = shift;
  own_.last_scan = stamp;
  LaserScan scan = std::move(own_.waiting.front());
  own_.waiting.pop_front();
  return scan;
}

bool ScanQueue::shift_odometry(Duration later) {
  const Duration wanted = own_.shift_wanted + later;
  if (std::abs(wanted.nanoseconds) > kMostShift.nanoseconds) return false;
  own_.shift_wanted = wanted;
  return true;
}

Duration ScanQueue::shift_at(Stamp scan) const {
  if (!is_shifting() || !own_.last_scan) return own_.shift;
  const Duration step =
      Duration::from_seconds(kScanQueue.shift_rate * std::abs((scan - *own_.last_scan).seconds()));
  const Duration missing = own_.shift_wanted - own_.shift;
  return own_.shift + std::clamp(missing, Duration{-step.nanoseconds}, step);
}

std::optional<OdometryReading> ScanQueue::reading_at(Stamp stamp) const {
  stamp = stamp + own_.shift;
  if (odometer_.newest()) {
    const auto known = odometer_.pose_at(stamp);
    if (!known) return {};
    return OdometryReading{.odom_T_robot = known->pose,
                           .path_m = own_.travel.path_m,
                           .turned_rad = own_.travel.turned_rad,
                           .turned_by_hand_rad = odometer_.turned_by_hand_rad(),
                           .silent_until = own_.travel.silent_until};
  }
  const auto heading = gyro_.heading_at(stamp);
  if (!heading) return {};
  return OdometryReading{.odom_T_robot = {0.0, 0.0, wrap_angle(*heading)},
                         .has_translation = false};
}

ScanQueue::State ScanQueue::state() const { return {odometer_.state(), gyro_.state(), own_}; }

void ScanQueue::restore(State state) {
  require_sound(state.own.waiting.empty() || state.own.first, "scans that wait for no start");
  require_sound(is_amount(state.own.travel.path_m) && is_amount(state.own.travel.turned_rad),
                "a path without a length");
  const auto is_within = [](Duration shift) {
    return shift <= kMostShift && shift >= Duration{-kMostShift.nanoseconds};
  };
  require_sound(is_within(state.own.shift) && is_within(state.own.shift_wanted),
                "clocks that are too far apart");
  odometer_.restore(std::move(state.odometer));
  gyro_.restore(std::move(state.gyro));
  own_ = std::move(state.own);
}

}  // namespace loopstone
