#pragma once

#include <array>

#include "localization/confidence.hpp"

namespace loopstone {

// Written by `bench/confidence.py fit`: the most likely weights of 155 simulated drives,
// 89750 scans.
inline constexpr std::array<double, kConfidenceFeatures> kConfidenceWeights{
    -0.2197,  // 1
    4.9337,   // explained
    -5.4499,  // violations
    0.0000,   // unexpected
    -4.9472,  // spread_m
    -1.1360,  // spread_rad
    -6.0174,  // innovation
    0.4113,   // followed_m
};

}  // namespace loopstone
