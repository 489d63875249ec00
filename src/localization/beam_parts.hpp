#pragma once

#include <cmath>
#include <limits>
#include <numbers>

#include "loopstone/base/error.hpp"
#include "loopstone/base/error_function.hpp"
#include "loopstone/localization/beam_model.hpp"

namespace loopstone {

inline constexpr double kNoBeamRange = std::numeric_limits<double>::infinity();

/// What each part of the mixture contributes to the likelihood of a measured range, weights
/// included.
struct BeamParts {
  double hit = 0.0;
  double in_the_way = 0.0;
  double max = 0.0;
  double random = 0.0;
  [[nodiscard]] double sum() const { return hit + in_the_way + max + random; }
};

/// Standard normal distribution.
[[nodiscard]] inline double normal_below(double z) {
  return 0.5 * complementary_error_function(-z * (0.5 * std::numbers::sqrt2));
}

/// The part of a normal distribution about `expected` that lies in [0, max range].
[[nodiscard]] inline double hit_share_in_range(double sigma, double expected, double max_range) {
  return normal_below((max_range - expected) / sigma) - normal_below(-expected / sigma);
}

/// Two ways to measure: a range in [0, max range), or nothing.
[[nodiscard]] inline bool is_return(double measured, double max_range) {
  return measured < max_range;
}

/// \param measured  not NaN, not negative
[[nodiscard]] inline BeamParts beam_parts(const BeamMixture& mixture, double max_range,
                                          double measured, double expected) {
  const bool shows_nothing = expected > max_range;
  BeamParts parts;
  if (!is_return(measured, max_range)) {
    parts.hit = shows_nothing ? mixture.hit_weight : 0.0;
    parts.max = mixture.max_weight;
    return parts;
  }
  if (!shows_nothing) {  // eq. 6.4 to 6.6
    const double z = (measured - expected) / mixture.hit_sigma_m;
    parts.hit = mixture.hit_weight * std::exp(-0.5 * z * z) /
                (mixture.hit_sigma_m * std::sqrt(2.0 * std::numbers::pi) *
                 hit_share_in_range(mixture.hit_sigma_m, expected, max_range));
  }
  const double room = shows_nothing ? max_range : expected;
  const double rate = mixture.short_rate_per_m;
  if (room <= 0.0) {
    parts.in_the_way = mixture.short_weight / max_range;
  } else if (measured <= room) {  // eq. 6.7 to 6.9
    parts.in_the_way =
        mixture.short_weight * rate * std::exp(-rate * measured) / -std::expm1(-rate * room);
  }
  parts.random = mixture.random_weight / max_range;  // eq. 6.11
  return parts;
}

inline void require_valid(const BeamMixture& mixture) {
  const double weights[] = {mixture.hit_weight, mixture.short_weight, mixture.max_weight,
                            mixture.random_weight};
  double sum = 0.0;
  for (const double weight : weights) {
    if (!(weight >= 0.0)) throw UsageError("a weight of the beam model must not be negative");
    sum += weight;
  }
  if (!(std::abs(sum - 1.0) < 1e-6)) {
    throw UsageError("the four weights of the beam model must sum to 1");
  }
  if (!(mixture.hit_sigma_m > 0.0 && mixture.hit_sigma_m < kNoBeamRange)) {
    throw UsageError("the beam model needs a hit_sigma_m above 0");
  }
  if (!(mixture.short_rate_per_m > 0.0 && mixture.short_rate_per_m < kNoBeamRange)) {
    throw UsageError("the beam model needs a short_rate_per_m above 0");
  }
}

}  // namespace loopstone
