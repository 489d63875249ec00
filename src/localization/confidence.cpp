#include "localization/confidence.hpp"

#include <algorithm>
#include <cmath>

#include "localization/confidence_weights.hpp"

namespace loopstone {

std::array<double, kConfidenceFeatures> confidence_features(const PoseEvidence& evidence) {
  return {1.0,
          evidence.explained,
          std::sqrt(evidence.violations),
          evidence.unexpected,
          std::min(evidence.spread_m, 1.0),
          std::min(evidence.spread_rad, 0.5) / 0.5,
          std::min(std::log1p(evidence.innovation), 3.0) / 3.0,
          std::min(evidence.followed_m, 5.0) / 5.0};
}

double pose_probability(const PoseEvidence& evidence) {
  const auto features = confidence_features(evidence);
  double sum = 0.0;
  for (std::size_t i = 0; i < features.size(); ++i) sum += kConfidenceWeights[i] * features[i];
  return evidence.mass * evidence.precision / (1.0 + std::exp(-sum));
}

}  // namespace loopstone
