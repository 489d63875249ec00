#include "localization/confidence.hpp"

#include <algorithm>
#include <cmath>

#include "localization/confidence_weights.hpp"

namespace loopstone {

std::array<double, kConfidenceFeatures> confidence_features(const PoseEvidence& evidence) {
  constexpr double kMostOdds = 5.0;
  constexpr double kLeast = 1e-9;
  const double mass = std::clamp(evidence.mass, kLeast, 1.0 - kLeast);
  const double odds = std::clamp(std::log(mass / (1.0 - mass)), -kMostOdds, kMostOdds);
  return {1.0,
          evidence.explained,
          evidence.violations,
          evidence.unexpected,
          odds / kMostOdds,
          std::min(evidence.spread_m, 1.0),
          std::min(evidence.spread_rad, 0.5) / 0.5,
          std::min(std::log1p(evidence.innovation), 4.0) / 4.0,
          std::min(evidence.followed_m, 5.0) / 5.0};
}

double pose_probability(const PoseEvidence& evidence) {
  const auto features = confidence_features(evidence);
  double sum = 0.0;
  for (std::size_t i = 0; i < features.size(); ++i) sum += kConfidenceWeights[i] * features[i];
  return 1.0 / (1.0 + std::exp(-sum));
}

}  // namespace loopstone
