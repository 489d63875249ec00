#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "loopstone/odometry/odometer.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/sensor/messages.hpp"

namespace loopstone {

/// A whole log by dead reckoning.
struct DeadReckoningResult {
  Trajectory trajectory;  ///< odom_T_robot at every scan, or at every reading when there is no scan
  std::int64_t scans = 0;
  std::int64_t scans_without_pose = 0;  ///< too far from any reading
  std::int64_t wheel_readings = 0;
  std::int64_t odometry_poses = 0;  ///< that the log itself reported
  std::int64_t gyro_samples = 0;
  std::int64_t turned_by_gyro = 0;  ///< wheel readings whose heading came from the gyro
  std::int64_t turned_by_wheels = 0;
  double gyro_bias_rad_s = 0.0;  ///< as learned by the end
};

/// Feeds a log to an Odometer and collects a pose for every scan; each scan waits until odometry
/// has come to its stamp.
class DeadReckoner {
 public:
  explicit DeadReckoner(const WheelModel& wheels, const OdometryOptions& options = {});

  /// Messages come in time order.
  void add(const SensorMessage& message);

  /// Ends the log. Call once.
  [[nodiscard]] DeadReckoningResult finish();

 private:
  struct Request {
    Stamp stamp;
    bool scan = false;
  };

  void answer_requests(Stamp now, bool all);

  Odometer odometer_;
  std::deque<Request> requests_{};
  Trajectory at_scans_{};
  Trajectory at_readings_{};
  DeadReckoningResult result_{};
};

}  // namespace loopstone
