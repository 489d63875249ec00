#include "loopstone/odometry/scan_queue.hpp"

#include <cmath>
#include <utility>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

constexpr Duration kPatience{250'000'000};
/// A stream that begins so long without odometry has none.
constexpr Duration kSilentStart{1'000'000'000};
/// Counts since the last reading are lost with the readings between; poses and counters go on,
/// unless the robot was off.
constexpr Duration kSilenceOfIncrements{2'000'000'000};
constexpr Duration kSilenceOfSums{60'000'000'000};

}  // namespace

void ScanQueue::add(const SensorMessage& message) {
  newest_ = stamp_of(message);
  if (!first_) first_ = newest_;
  if (const auto* scan = std::get_if<LaserScan>(&message)) {
    waiting_.push_back(*scan);
  } else if (const auto* ticks = std::get_if<WheelTicks>(&message)) {
    odometer_.add(*ticks);
    increments_ = !counts_are_cumulative_;
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
  if (!newest || (travel_.stamp && *newest <= *travel_.stamp)) return;
  const Pose2 odom_T_robot = odometer_.pose_at(*newest)->pose;
  if (travel_.stamp) {
    const Pose2 step = travel_.odom_T_robot.inverse() * odom_T_robot;
    travel_.path_m += std::hypot(step.x, step.y);
    travel_.turned_rad += std::abs(step.yaw);
    const Duration silence = increments_ ? kSilenceOfIncrements : kSilenceOfSums;
    if (*newest - *travel_.stamp > silence) travel_.silent_until = *newest;
  }
  travel_.stamp = newest;
  travel_.odom_T_robot = odom_T_robot;
}

void ScanQueue::finish() {
  odometer_.finish();
  finished_ = true;
}

std::optional<LaserScan> ScanQueue::next() {
  if (waiting_.empty()) return {};
  const Stamp stamp = waiting_.front().stamp;
  auto known_until = odometer_.newest();
  if (!known_until) known_until = gyro_.newest();
  const bool known = known_until && *known_until >= stamp;
  const bool may_come = known_until || newest_ - *first_ <= kSilentStart;
  if (!known && may_come && !finished_ && newest_ - stamp < kPatience) return {};
  LaserScan scan = std::move(waiting_.front());
  waiting_.pop_front();
  return scan;
}

std::optional<OdometryReading> ScanQueue::reading_at(Stamp stamp) const {
  if (odometer_.newest()) {
    const auto known = odometer_.pose_at(stamp);
    if (!known) return {};
    return OdometryReading{.odom_T_robot = known->pose,
                           .path_m = travel_.path_m,
                           .turned_rad = travel_.turned_rad,
                           .silent_until = travel_.silent_until};
  }
  const auto heading = gyro_.heading_at(stamp);
  if (!heading) return {};
  return OdometryReading{.odom_T_robot = {0.0, 0.0, wrap_angle(*heading)},
                         .has_translation = false};
}

}  // namespace loopstone
