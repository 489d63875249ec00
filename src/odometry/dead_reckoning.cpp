#include "loopstone/odometry/dead_reckoning.hpp"

#include <utility>
#include <variant>

namespace loopstone {

namespace {

// A scan that odometry has not reached by then is answered by extrapolation, or not at all.
constexpr Duration kPatience{1'000'000'000};

}  // namespace

DeadReckoner::DeadReckoner(const WheelModel& wheels, const OdometryOptions& options)
    : odometer_(wheels, options) {}

void DeadReckoner::add(const SensorMessage& message) {
  const Stamp stamp = stamp_of(message);
  if (std::holds_alternative<LaserScan>(message)) {
    ++result_.scans;
    requests_.push_back({stamp, true});
  } else if (const auto* ticks = std::get_if<WheelTicks>(&message)) {
    ++result_.wheel_readings;
    odometer_.add(*ticks);
    requests_.push_back({stamp, false});
  } else if (const auto* imu = std::get_if<ImuSample>(&message)) {
    ++result_.gyro_samples;
    odometer_.add(*imu);
  } else if (const auto* pose = std::get_if<OdometryPose>(&message)) {
    ++result_.odometry_poses;
    odometer_.add(*pose);
    requests_.push_back({stamp, false});
  }
  answer_requests(stamp, false);
}

void DeadReckoner::answer_requests(Stamp now, bool all) {
  while (!requests_.empty()) {
    const Request request = requests_.front();
    const auto known_until = odometer_.newest();
    const bool ready = known_until && *known_until >= request.stamp;
    if (!all && !ready && now - request.stamp < kPatience) return;
    requests_.pop_front();
    const auto known = odometer_.pose_at(request.stamp);
    if (!known) {
      if (request.scan) ++result_.scans_without_pose;
      continue;
    }
    (request.scan ? at_scans_ : at_readings_).append(request.stamp, known->pose);
  }
}

DeadReckoningResult DeadReckoner::finish() {
  odometer_.finish();
  answer_requests(Stamp{}, true);
  result_.trajectory = std::move(result_.scans > 0 ? at_scans_ : at_readings_);
  result_.turned_by_gyro = odometer_.turned_by_gyro();
  result_.turned_by_wheels = odometer_.turned_by_wheels();
  result_.gyro_bias_rad_s = odometer_.gyro_bias_rad_s();
  return std::move(result_);
}

}  // namespace loopstone
