#pragma once

#include "loopstone/report/map_figures.hpp"

namespace loopstone {

/// numerator / denominator; 0 when the denominator is.
[[nodiscard]] inline double ratio_or_zero(double numerator, double denominator) {
  return denominator > 0.0 ? numerator / denominator : 0.0;
}

}  // namespace loopstone
