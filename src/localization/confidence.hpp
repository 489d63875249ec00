#pragma once

#include <array>
#include <cstddef>

#include "loopstone/localization/localization_result.hpp"

namespace loopstone {

/// The evidence as the probability is computed from it: each near [0, 1] or [-1, 1], and capped, so that no single one decides
/// alone.
inline constexpr std::size_t kConfidenceFeatures = 9;
[[nodiscard]] std::array<double, kConfidenceFeatures> confidence_features(
    const PoseEvidence& evidence);

/// Probability that a pose with that evidence is within 0.2 m and 5 deg of the truth: logistic regression on the features,
/// fitted to simulated drives whose truth is known; see bench/confidence.py, which writes confidence_weights.hpp.
[[nodiscard]] double pose_probability(const PoseEvidence& evidence);

}  // namespace loopstone
