#pragma once

#include <string>
#include <vector>

#include "loopstone/geometry/pose2.hpp"

namespace loopstone::app {

/// Finite numbers between commas. Throws UsageError that names the flag and the word that is none.
[[nodiscard]] std::vector<double> parse_numbers(const std::string& flag, const std::string& text);

/// "X,Y,YAW" in metres and radians. Throws UsageError.
[[nodiscard]] Pose2 parse_pose2(const std::string& flag, const std::string& text);

}  // namespace loopstone::app
