#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <variant>

#include "loopstone/geometry/angle.hpp"
#include "support/simulated_log.hpp"
#include "support/test_scale.hpp"

// A robot with a laser on each of two opposite corners, as most robots in halls have them.
namespace loopstone::test {

/// On opposite corners, facing away from one another.
inline const Pose2 kFrontCorner{0.3, 0.2, radians(45.0)};
inline const Pose2 kRearCorner{-0.3, -0.2, radians(-135.0)};

/// What one of the robot's lasers sees of a drive; the drive is the same whatever the laser.
[[nodiscard]] inline SimulatedLog seen_from(const Pose2& robot_T_lidar, double rate_hz,
                                            const std::string& world, std::uint64_t seed) {
  RobotModel robot;
  robot.lidars[0].robot_T_lidar = robot_T_lidar;
  SimulationOptions options{.duration_s = small_scale() ? 40.0 : 150.0, .odometry_poses = true};
  options.laser.rate_hz = rate_hz;
  options.laser.beams = 361;
  options.laser.fov_rad = kPi;
  options.laser.range_max_m = 6.0;
  SimulatedLog log = simulate_log(world, seed, options, robot);
  for (SensorMessage& message : log.messages) {
    if (auto* scan = std::get_if<LaserScan>(&message)) scan->robot_T_lidar = robot_T_lidar;
  }
  return log;
}

/// Both lasers' scans in the order of their stamps, which run apart.
[[nodiscard]] inline SimulatedLog both(const SimulatedLog& front, const SimulatedLog& rear) {
  SimulatedLog log = front;
  for (LaserScan scan : rear.scans()) {
    scan.lidar = 1;
    log.messages.emplace_back(std::move(scan));
  }
  std::ranges::stable_sort(log.messages, {}, stamp_of);
  return log;
}

}  // namespace loopstone::test
