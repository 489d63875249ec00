#pragma once

#include <cmath>
#include <limits>

#include "loopstone/base/rng.hpp"
#include "loopstone/localization/beam_model.hpp"

namespace loopstone::test {

/// Any mixture, all parts present.
[[nodiscard]] inline BeamMixture random_mixture(Rng& rng) {
  BeamMixture mixture{.hit_weight = rng.uniform(0.2, 1.0),
                      .short_weight = rng.uniform(0.05, 0.5),
                      .max_weight = rng.uniform(0.02, 0.5),
                      .random_weight = rng.uniform(0.02, 0.5),
                      .hit_sigma_m = rng.uniform(0.02, 0.5),
                      .short_rate_per_m = rng.uniform(0.1, 3.0)};
  const double sum =
      mixture.hit_weight + mixture.short_weight + mixture.max_weight + mixture.random_weight;
  mixture.hit_weight /= sum;
  mixture.short_weight /= sum;
  mixture.max_weight /= sum;
  mixture.random_weight /= sum;
  return mixture;
}

/// A measured range, drawn part by part: nothing of the library's formulas is in here.
[[nodiscard]] inline double sample_range(const BeamMixture& mixture, double max_range_m,
                                         double expected_m, Rng& rng) {
  constexpr double kNothing = std::numeric_limits<double>::infinity();
  const bool shows_nothing = expected_m > max_range_m;
  double part = rng.uniform();
  if ((part -= mixture.hit_weight) < 0.0) {
    if (shows_nothing) return kNothing;
    while (true) {
      const double range = rng.normal(expected_m, mixture.hit_sigma_m);
      if (range >= 0.0 && range < max_range_m) return range;
    }
  }
  if ((part -= mixture.short_weight) < 0.0) {
    const double room = shows_nothing ? max_range_m : expected_m;
    if (room <= 0.0) return rng.uniform(0.0, max_range_m);
    while (true) {
      const double range = -std::log(1.0 - rng.uniform()) / mixture.short_rate_per_m;
      if (range <= room) return range;
    }
  }
  if ((part -= mixture.max_weight) < 0.0) return kNothing;
  return rng.uniform(0.0, max_range_m);
}

}  // namespace loopstone::test
