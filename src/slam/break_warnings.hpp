#pragma once

#include <string>
#include <vector>

#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// When the laser said nothing, what carried the path across, and what ties both sides: in plain
/// words, with times since the first scan.
[[nodiscard]] std::vector<std::string> break_warnings(const MapResult& result);

}  // namespace loopstone
