#include "loopstone/slam/scan_queue.hpp"

#include <utility>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

constexpr Duration kPatience{250'000'000};

}  // namespace

void ScanQueue::add(const SensorMessage& message) {
  newest_ = stamp_of(message);
  if (const auto* scan = std::get_if<LaserScan>(&message)) {
    waiting_.push_back(*scan);
  } else if (const auto* ticks = std::get_if<WheelTicks>(&message)) {
    odometer_.add(*ticks);
  } else if (const auto* imu = std::get_if<ImuSample>(&message)) {
    odometer_.add(*imu);
    gyro_.add(*imu);
  } else if (const auto* pose = std::get_if<OdometryPose>(&message)) {
    odometer_.add(*pose);
  }
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
  if (!known && !finished_ && newest_ - stamp < kPatience) return {};
  LaserScan scan = std::move(waiting_.front());
  waiting_.pop_front();
  return scan;
}

std::optional<OdometryReading> ScanQueue::reading_at(Stamp stamp) const {
  if (odometer_.newest()) {
    const auto known = odometer_.pose_at(stamp);
    if (!known) return {};
    return OdometryReading{known->pose};
  }
  const auto heading = gyro_.heading_at(stamp);
  if (!heading) return {};
  return OdometryReading{{0.0, 0.0, wrap_angle(*heading)}, false};
}

}  // namespace loopstone
