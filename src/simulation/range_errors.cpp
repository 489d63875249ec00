#include "simulation/range_errors.hpp"

#include <algorithm>
#include <cmath>

#include "loopstone/base/hypotenuse.hpp"
#include "simulation/systematic.hpp"

namespace loopstone {

namespace {

/// A surface that leans spreads the echo over the beam's footprint; the laser finds the echo's
/// middle to about a tenth of that.
constexpr double kShareOfFootprint = 0.1;
constexpr double kMostOfFootprint = 0.05;  ///< [m]

}  // namespace

RangeErrors::RangeErrors(const RealismRange& options, Rng rng) : options_(options), rng_(rng) {
  bias_m_ = systematic(options.bias_m, rng_);
  scale_ = 1.0 + systematic(options.scale_error, rng_);
}

double RangeErrors::spread_m(double range_m, double tan_incidence) const {
  const double by_range = options_.noise_per_m * range_m;
  const double depth = options_.beam_width_rad * range_m * tan_incidence;
  const double footprint = std::min(kMostOfFootprint, kShareOfFootprint * depth);
  return hypotenuse(by_range, footprint);
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
