#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "loopstone/slam/calibration.hpp"

namespace loopstone {

/// The object "calibration" of summary.json.
[[nodiscard]] nlohmann::ordered_json calibration_json(const Calibration& calibration);

/// A part of the report; empty where nothing is known.
[[nodiscard]] std::string calibration_html(const Calibration& calibration);

}  // namespace loopstone
