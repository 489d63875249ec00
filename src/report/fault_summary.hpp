#pragma once

#include <nlohmann/json.hpp>

#include "loopstone/slam/map_result.hpp"

namespace loopstone {

// What went wrong during a run, for summary.json; times count from the first scan.

/// When odometry was found wrong.
[[nodiscard]] nlohmann::ordered_json odometry_faults(const MapResult& result);
/// When the laser was blocked or frozen.
[[nodiscard]] nlohmann::ordered_json laser_faults(const MapResult& result);
/// When the laser did not hold the pose, and what ties both sides.
[[nodiscard]] nlohmann::ordered_json path_breaks(const MapResult& result);
/// Drives after the first.
[[nodiscard]] nlohmann::ordered_json drives_json(const MapResult& result);

}  // namespace loopstone
