#pragma once

#include <array>

#include "localization/confidence.hpp"

namespace loopstone {

// Written by `bench/confidence.py fit`: the most likely weights of 155 simulated drives, 89750 scans.
inline constexpr std::array<double, kConfidenceFeatures> kConfidenceWeights{
    -3.9750,  // 1
    8.0709,   // explained
    -8.1148,  // violations
    0.0000,   // unexpected
    -5.1513,  // spread_m
    -1.8096,  // spread_rad
    -6.9184,  // innovation
    1.0714,   // followed_m
};

}  // namespace loopstone
