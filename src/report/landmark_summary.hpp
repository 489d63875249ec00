#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "loopstone/localization/landmark_mapping.hpp"

namespace loopstone {

/// Every figure of the landmarks, units in the key names.
[[nodiscard]] nlohmann::ordered_json landmarks_json(const LandmarkMapping& mapping);

/// The section of a report.
[[nodiscard]] std::string html_landmarks(const LandmarkMapping& mapping);

}  // namespace loopstone
