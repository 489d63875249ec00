#pragma once

#include <array>

#include "localization/confidence.hpp"

namespace loopstone {

// Written by `bench/confidence.py fit`: the most likely weights of 286 drives, 357709
// scans.
inline constexpr std::array<double, kConfidenceFeatures> kConfidenceWeights{
    -2.8264,  // 1
    4.0490,   // explained of the rest
    -6.0761,  // violations
    -1.1887,  // unexpected
    1.4128,   // lately explained of the rest
    -4.5755,  // lately violations
    0.0000,   // lately unexpected
    1.4854,   // lately known
    0.9570,   // along explained of the rest
    -3.7155,  // along violations
    0.0000,   // along unexpected
    0.6320,   // along known
    -0.8235,  // along silent
    -1.5714,  // spread_m
    -0.7375,  // spread_rad
    -6.2843,  // innovation
    1.1886,   // followed and explained
    -5.7598,  // unproven
};

}  // namespace loopstone
