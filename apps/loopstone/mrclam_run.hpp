#pragma once

#include <string>

#include "log_run.hpp"
#include "loopstone/localization/landmark_tracking_options.hpp"
#include "loopstone/pipeline/log_landmarks.hpp"

// What commands that read MRCLAM's folders share.

namespace loopstone::app {

/// Says what it holds and what is left out. Throws as read_mrclam_drive() does.
[[nodiscard]] MrclamLog read_mrclam_run(const std::string& path, const LogFlags& flags,
                                        const SightingNoise& noise, const AppContext& context);

}  // namespace loopstone::app
