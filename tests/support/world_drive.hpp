#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/simulation/simulate.hpp"

namespace loopstone::test {

/// A drive, and its truth in the frame of the building.
struct WorldDrive {
  std::vector<SensorMessage> messages{};
  Trajectory truth{};
};

/// \param start    the drive begins at so many of the world's places
/// \param clock_s  added to all stamps
[[nodiscard]] inline WorldDrive drive_in(World world, std::uint64_t seed, double duration_s,
                                         std::size_t start, double clock_s, int beams = 361) {
  const Eigen::Vector2d from = world.places[start % world.places.size()];
  if (start > 0) {
    world.map_T_start = {from.x(), from.y(), 1.0};
    world.returns.clear();
  }
  SimulationOptions options{.duration_s = duration_s};
  options.laser.beams = beams;
  WorldDrive drive;
  const Duration shift = Duration::from_seconds(clock_s);
  simulate(
      world, RobotModel{}, options, seed,
      {.message =
           [&](SensorMessage message) {
             std::visit([&](auto& known) { known.stamp = known.stamp + shift; }, message);
             drive.messages.push_back(std::move(message));
           },
       .truth =
           [&](const StampedPose2& pose) { drive.truth.append(pose.stamp + shift, pose.pose); }});
  return drive;
}

}  // namespace loopstone::test
