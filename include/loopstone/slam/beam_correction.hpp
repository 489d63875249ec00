#pragma once

#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/slam/calibration.hpp"
#include "loopstone/slam/map_result.hpp"

namespace loopstone {

// A laser that hangs upside down, and a sweep that no log tells, bend the map itself. When a run
// is over and its calibration says so, the log is mapped once more:
//
//   MapResult result = first.finish();
//   if (result.calibration.beams_are_off()) {
//     const Calibration found = result.calibration;
//     Mapper second(corrected_beams(robot, found), options, threads);  // the log, from its start
//     result = second.finish();
//     tell_of_beams(found, result);
//   }

/// The robot with beams as the drive tells them.
[[nodiscard]] RobotModel corrected_beams(RobotModel robot, const Calibration& found);

/// Notes in a map that was made with corrected beams what the first one had found, and warns.
void tell_of_beams(const Calibration& found, MapResult& result);

}  // namespace loopstone
