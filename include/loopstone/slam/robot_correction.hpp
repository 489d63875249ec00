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
//   const Calibration found = beside({}, first.judge_robot());
//   if (!found.map_is_bent()) return first.finish();
//   Mapper second(corrected_robot(robot, found), options, threads);  // the log, from its start
//   MapResult result = second.finish();
//   tell_of_correction(found, result);
//
// One fault may hide another: what the second mapping finds goes beside() what was found before,
// and the drive is mapped once more with both.

/// How often a drive is mapped anew, at most.
inline constexpr int kMostMadeAnew = 2;

/// The robot with beams, and odometry's scale, as the drive tells them.
[[nodiscard]] RobotModel corrected_robot(RobotModel robot, const Calibration& found);

/// What a mapping found of a robot that was corrected by what had been found before, with that.
[[nodiscard]] Calibration beside(const Calibration& before, Calibration found);

/// Notes in the map of a corrected robot what had been found before, and warns. Returns the words
/// of the warnings.
std::vector<std::string> tell_of_correction(const Calibration& found, MapResult& result);

}  // namespace loopstone
