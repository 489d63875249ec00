#pragma once

#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/slam/calibration.hpp"
#include "loopstone/slam/map_result.hpp"

namespace loopstone {

// A laser that hangs upside down, and a sweep that no log tells, bend the map itself. When a log
// is over and the drive says so, it is mapped once more:
//
//   const Calibration found = first.judge_beams();
//   if (!found.beams_are_off()) return first.finish();
//   Mapper second(corrected_beams(robot, found), options, threads);  // the log, from its start
//   MapResult result = second.finish();
//   tell_of_beams(found, result);

/// The robot with beams as the drive tells them.
[[nodiscard]] RobotModel corrected_beams(RobotModel robot, const Calibration& found);

/// Notes in a map that was made with corrected beams what the first one had found, and warns.
void tell_of_beams(const Calibration& found, MapResult& result);

}  // namespace loopstone
