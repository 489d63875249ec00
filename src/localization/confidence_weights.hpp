#pragma once

#include <array>

#include "localization/confidence.hpp"

namespace loopstone {

inline constexpr std::array<double, kConfidenceFeatures> kConfidenceWeights{-2.0, 8.0,  -12.0, -1.0,
                                                                            -3.0, -3.0, -3.0,  0.5};

}  // namespace loopstone
