#pragma once

#include <optional>
#include <string>

#include "loopstone/localization/localizer.hpp"

namespace loopstone::app {

/// What --initial X,Y,YAW and --initial-sigma M,RAD say; nothing without the first. Throws
/// UsageError.
[[nodiscard]] std::optional<InitialPose> initial_pose(const std::string& initial,
                                                      const std::string& sigma);

}  // namespace loopstone::app
