#pragma once

#include <string>
#include <vector>

#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// What the user should know of the odometry of a run, in plain words; times count from the first
/// scan.
[[nodiscard]] std::vector<std::string> odometry_warnings(const MapResult& result);

}  // namespace loopstone
