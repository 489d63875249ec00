#pragma once

#include <string>
#include <vector>

#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/slam/calibration.hpp"
#include "loopstone/slam/map_result.hpp"

namespace loopstone {

// A laser that hangs upside down, a sweep that no log tells, and odometry that counts too long a
// way along bare corridors bend the map itself. When a log is over and the drive says so, it is
// mapped once more:
//
//   const Calibration found = first.judge_robot();
//   if (!found.map_is_bent()) return first.finish();
//   Mapper second(corrected_robot(robot, found), options, threads);  // the log, from its start
//   MapResult result = second.finish();
//   tell_of_correction(found, result);

/// The robot with beams, and odometry's scale, as the drive tells them.
[[nodiscard]] RobotModel corrected_robot(RobotModel robot, const Calibration& found);

/// Notes in the map of a corrected robot what the first one had found, and warns. Returns the words
/// of the warnings.
std::vector<std::string> tell_of_correction(const Calibration& found, MapResult& result);

}  // namespace loopstone
