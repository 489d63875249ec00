#include "simulation/range_errors.hpp"

#include <algorithm>
#include <cmath>

#include "simulation/systematic.hpp"

namespace loopstone {

namespace {

/// What a beam's footprint can add at most: electronics answer to its nearer part [m].
constexpr double kMostOfFootprint = 0.1;

}  // namespace

RangeErrors::RangeErrors(const RealismRange& options, Rng rng) : options_(options), rng_(rng) {
  bias_m_ = systematic(options.bias_m, rng_);
  scale_ = 1.0 + systematic(options.scale_error, rng_);
}

double RangeErrors::spread_m(double range_m, double tan_incidence) const {
  const double by_range = options_.noise_per_m * range_m;
  // The power of a Gaussian beam has a standard deviation of a quarter of its width; a surface that
  // leans spreads it in depth.
  const double footprint =
      std::min(kMostOfFootprint, 0.25 * options_.beam_width_rad * range_m * tan_incidence);
  return std::hypot(by_range, footprint);
}

double RangeErrors::measured(double range_m, double tan_incidence) {
  const double normal = rng_.normal();
  if (!std::isfinite(range_m)) return range_m;
  return scale_ * range_m + bias_m_ + normal * spread_m(range_m, tan_incidence);
}

void RangeErrors::note(RealismRecord& record) const {
  record.facts.push_back({"range", "bias_m", bias_m_});
  record.facts.push_back({"range", "scale", scale_});
}

}  // namespace loopstone
