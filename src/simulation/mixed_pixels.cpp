#include "simulation/mixed_pixels.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {

std::array<double, 4> MixedPixels::parts_rad() const {
  const double w = options_.beam_width_rad;
  return {-0.4 * w, -0.2 * w, 0.2 * w, 0.4 * w};
}

BeamEcho MixedPixels::merged(const BeamEcho& middle, const std::array<BeamEcho, 4>& parts) {
  const double chance = rng_.uniform();
  const double place = rng_.uniform();
  const BeamEcho* nearest = &middle;
  const BeamEcho* farthest = &middle;
  for (const BeamEcho& part : parts) {
    if (part.range_m < nearest->range_m) nearest = &part;
    if (part.range_m > farthest->range_m) farthest = &part;
  }
  const double step = farthest->range_m - nearest->range_m;
  if (!(step >= options_.least_step_m)) return middle;
  const auto is_near = [&](const BeamEcho& part) {
    return part.range_m - nearest->range_m < farthest->range_m - part.range_m;
  };
  const auto near =
      static_cast<double>(std::ranges::count_if(parts, is_near)) + (is_near(middle) ? 1.0 : 0.0);
  const double share = near / static_cast<double>(parts.size() + 1);
  // Echoes that overlap are told as one between them, about where their energy lies.
  if (step < options_.blend_m) {
    const double weight = std::clamp(share + 0.5 * (place - 0.5), 0.0, 1.0);
    return {weight * nearest->range_m + (1.0 - weight) * farthest->range_m, 0.0, nearest->surface};
  }
  return chance < share ? *nearest : *farthest;
}

}  // namespace loopstone
