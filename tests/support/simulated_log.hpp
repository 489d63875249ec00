#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/simulation/simulate.hpp"

namespace loopstone::test {

/// A whole simulated log in memory.
struct SimulatedLog {
  World world;
  RobotModel robot;
  std::vector<SensorMessage> messages;
  Trajectory truth;  ///< map_T_robot at every scan's stamp
  SimulationSummary summary;

  [[nodiscard]] std::vector<LaserScan> scans() const;
};

/// For example simulate_log("office", 1, {.duration_s = 60.0, .odometry_poses = true}).
[[nodiscard]] SimulatedLog simulate_log(const std::string& world, std::uint64_t seed,
                                        const SimulationOptions& options = {},
                                        const RobotModel& robot = {});

/// Options without any noise, bias, slip, dropout or clock offset; the sweep stays.
[[nodiscard]] SimulationOptions noise_free(SimulationOptions options = {});

}  // namespace loopstone::test
