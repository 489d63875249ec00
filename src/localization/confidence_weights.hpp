#pragma once

#include <array>

#include "localization/confidence.hpp"

namespace loopstone {

inline constexpr std::array<double, kConfidenceFeatures> kConfidenceWeights{
    -3.0, 6.0, -8.0, -1.0, 3.0, -6.0, -6.0, -2.0, 1.5};

}  // namespace loopstone
