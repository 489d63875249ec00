#pragma once

#include <string>
#include <vector>

#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// Faults by which the map itself may be wrong, though its scans agree with one another: of the
/// laser, of its mount, or of either the laser or odometry where the data can't tell which. Plain
/// words, with times since the first scan.
[[nodiscard]] std::vector<std::string> sensor_faults(const MapResult& result);

}  // namespace loopstone
