#pragma once

#include <memory>
#include <string>

#include "loopstone/formats/log_reader.hpp"

namespace loopstone {

/// Writes one set of the UCSD layout into a folder, which is made if needed (see ucsd_sensors.hpp
/// for the arrays).
///
/// Only sensors that sent something get a file. What the layout has no place for goes into arrays
/// that other readers pass over: `robot_T_lidar` and `time_increment` in HokuyoN.npz, poses of the
/// robot's own odometry in OdometryN.npz. Pictures of a camera are copied into dataRGBD, unless
/// they are there already under the names that they get: numbered in the order in which the frames
/// come. Memory: all readings but the ranges, which go to a temporary file beside the target.
[[nodiscard]] std::unique_ptr<LogWriter> create_ucsd_log(const std::string& folder,
                                                         const RobotModel& robot, int set);

}  // namespace loopstone
