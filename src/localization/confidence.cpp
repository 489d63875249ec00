#include "localization/confidence.hpp"

#include <algorithm>
#include <cmath>

#include "localization/confidence_weights.hpp"

namespace loopstone {

double explained_of_rest(double explained, double unexpected) {
  constexpr double kLeastSeen = 0.3;
  return std::min(1.0, explained / std::max(kLeastSeen, 1.0 - unexpected));
}

std::array<double, kConfidenceFeatures> confidence_features(const PoseEvidence& evidence) {
  constexpr double kFollowedM = 10.0;
  const FitOverWay& lately = evidence.lately;
  const FitOverWay& along = evidence.along;
  const double explained_along = explained_of_rest(along.explained, along.unexpected);
  return {1.0,
          explained_of_rest(evidence.explained, evidence.unexpected),
          std::sqrt(evidence.violations),
          evidence.unexpected,
          explained_of_rest(lately.explained, lately.unexpected),
          std::sqrt(lately.violations),
          lately.unexpected,
          lately.known,
          explained_along,
          std::sqrt(along.violations),
          along.unexpected,
          along.known,
          std::sqrt(along.silent),
          std::min(evidence.spread_m, 1.0),
          std::min(evidence.spread_rad, 0.5) / 0.5,
          std::min(std::log1p(evidence.innovation), 3.0) / 3.0,
          explained_along * std::min(evidence.followed_m, kFollowedM) / kFollowedM,
          evidence.unproven};
}

double fit_probability(const PoseEvidence& evidence) {
  const auto features = confidence_features(evidence);
  double sum = 0.0;
  for (std::size_t i = 0; i < features.size(); ++i) sum += kConfidenceWeights[i] * features[i];
  return 1.0 / (1.0 + std::exp(-sum));
}

double pose_probability(const PoseEvidence& evidence) {
  return evidence.mass * evidence.precision * fit_probability(evidence);
}

}  // namespace loopstone
