#pragma once

#include <array>

#include "localization/confidence.hpp"

namespace loopstone {

// Written by `bench/confidence.py fit`: the most likely weights of 286 drives, 357744
// scans.
inline constexpr std::array<double, kConfidenceFeatures> kConfidenceWeights{
    -2.4734,  // 1
    4.8795,   // explained of the rest
    -5.5507,  // violations
    -0.8444,  // unexpected
    1.8351,   // lately explained of the rest
    -3.7723,  // lately violations
    0.0000,   // lately unexpected
    0.7035,   // lately known
    0.3992,   // along explained of the rest
    -2.9312,  // along violations
    0.0000,   // along unexpected
    0.5276,   // along known
    -0.7435,  // along silent
    -1.4555,  // spread_m
    -0.5663,  // spread_rad
    -6.4857,  // innovation
    0.9581,   // followed and explained
    -6.3491,  // unproven
};

}  // namespace loopstone
