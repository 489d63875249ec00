#include "simulation/beam_dropouts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace loopstone {

BeamDropouts::BeamDropouts(const RealismDropouts& options, Rng rng)
    : options_(options), rng_(rng.fork(1)), surfaces_(rng.fork(2)) {}

double BeamDropouts::chance_of(const BeamEcho& met) const {
  double seen = 1.0 - options_.share;
  const double incidence = std::atan(met.tan_incidence);
  if (incidence > options_.grazing_rad)
    seen *= 1.0 - (incidence - options_.grazing_rad) / (0.5 * kPi - options_.grazing_rad);
  const bool is_surface = met.surface != SurfaceHit::kNothing;
  if (is_surface && surfaces_.fork(met.surface).uniform() < options_.dark_share) {
    // Light that comes back falls with the square of the distance.
    const double ratio = met.range_m / options_.dark_reach_m;
    seen /= 1.0 + ratio * ratio;
  }
  return 1.0 - seen;
}

double BeamDropouts::measured(double range_m, const BeamEcho& met) {
  const double chance = rng_.uniform();
  const double kind = rng_.uniform();
  if (!std::isfinite(range_m) || chance >= chance_of(met)) return range_m;
  return kind < options_.seen_as_free ? std::numeric_limits<double>::infinity()
                                      : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace loopstone
