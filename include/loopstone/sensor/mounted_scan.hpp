#pragma once

#include <optional>

#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {

/// No laser takes longer for a sweep [s]; robot files that say so are wrong.
inline constexpr double kLongestSweepS = 1.0;

/// The scan with what its robot tells of the laser and the scan does not: beams that go round the
/// other way, the time from beam to beam. Nothing when the scan is right as it is. Apply it once.
[[nodiscard]] std::optional<LaserScan> as_mounted(const LaserScan& scan, const RobotModel& robot);

/// Likewise of any message: nothing when it is right as it is.
[[nodiscard]] std::optional<SensorMessage> as_mounted(const SensorMessage& message,
                                                      const RobotModel& robot);

}  // namespace loopstone
