#pragma once

#include <memory>
#include <string>

#include "loopstone/formats/log_reader.hpp"

namespace loopstone {

/// Writes CARMEN text, compressed when the name ends in .gz or .bz2.
///
/// A scan becomes FLASER (RLASER for lidar 1) when CARMEN's rule gives its beams their directions,
/// else ROBOTLASER1, which states them (ROBOTLASER3 for lidar 2, and so on); RAWLASER1 when no
/// odometry is known. Its odometry pose is that of the same stamp, or between its neighbours.
/// Numbers are written with as many digits as bring the same value back.
[[nodiscard]] std::unique_ptr<LogWriter> create_carmen_log(const std::string& path,
                                                           const RobotModel& robot);

}  // namespace loopstone
