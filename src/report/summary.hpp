#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "loopstone/report/map_figures.hpp"

namespace loopstone {

/// numerator / denominator; 0 when the denominator is.
[[nodiscard]] inline double ratio_or_zero(double numerator, double denominator) {
  return denominator > 0.0 ? numerator / denominator : 0.0;
}

/// null for nothing.
[[nodiscard]] inline nlohmann::ordered_json optional_number(const std::optional<double>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
}

}  // namespace loopstone
