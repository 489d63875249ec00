#pragma once

#include <array>
#include <cstddef>

#include "loopstone/localization/localization_result.hpp"

namespace loopstone {

/// Of the returns that are not of people and other things that the map lacks, the share that lies
/// on a wall.
[[nodiscard]] double explained_of_rest(double explained, double unexpected);

/// The evidence as the probability is computed from it: each in [0, 1], capped, so that no single
/// one decides alone; the first is 1. The first few beams through a wall say most, so of their
/// share the root is taken.
inline constexpr std::size_t kConfidenceFeatures = 18;
[[nodiscard]] std::array<double, kConfidenceFeatures> confidence_features(
    const PoseEvidence& evidence);

/// Probability that scans fit so from a right pose: the last factor of pose_probability().
[[nodiscard]] double fit_probability(const PoseEvidence& evidence);

/// Probability that a pose with that evidence is within 0.2 m and 5 deg of the truth:
///   the belief in its place
///   times the probability that a Gaussian of the pose's covariance stays within those bounds
///   times the probability that the scans fit, a logistic function of the features above.
/// The last one was fitted to simulated drives whose truth is known: bench/confidence.py writes
/// confidence_weights.hpp.
[[nodiscard]] double pose_probability(const PoseEvidence& evidence);

}  // namespace loopstone
