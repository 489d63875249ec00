#pragma once

#include <array>

#include "localization/confidence.hpp"

namespace loopstone {

// Written by `bench/confidence.py fit`: the most likely weights of 286 drives, 357709
// scans; of unproven alone, the others as they were.
inline constexpr std::array<double, kConfidenceFeatures> kConfidenceWeights{
    -6.7514,  // 1
    4.6449,   // explained of the rest
    -6.0688,  // violations
    -1.0642,  // unexpected
    3.1669,   // lately explained of the rest
    -5.8579,  // lately violations
    0.0000,   // lately unexpected
    0.0000,   // lately known
    3.7938,   // along explained of the rest
    -6.6085,  // along violations
    0.0000,   // along unexpected
    0.0000,   // along known
    -1.8427,  // along silent
    -2.5174,  // spread_m
    -1.4534,  // spread_rad
    -5.7258,  // innovation
    2.1977,   // followed and explained
    -3.3420,  // unproven
};

}  // namespace loopstone
