#include "slam/place_descriptor.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "loopstone/base/thinned.hpp"

namespace loopstone {

namespace {

/// Pairs among so many evenly spaced pieces of surface.
constexpr std::size_t kSample = 300;
/// Fewer describe nothing.
constexpr std::size_t kLeast = 60;
constexpr float kStepM = 0.5F;
constexpr std::size_t kDistances = 20;
constexpr std::size_t kAngles = 4;
constexpr std::size_t kFacings = 4;
/// Nearer pairs are pieces of one wall anywhere.
constexpr float kNearestM = 0.3F;
constexpr float kCosine45 = 0.70710678F;

/// Quarter of [0, pi] that the angle lies in.
std::size_t quarter_of(float cosine) {
  return (cosine < kCosine45 ? 1U : 0U) + (cosine < 0.0F ? 1U : 0U) +
         (cosine < -kCosine45 ? 1U : 0U);
}

}  // namespace

std::vector<float> describe_place(std::span<const SurfacePoint> surfaces) {
  if (surfaces.size() < kLeast) return {};
  const std::vector<SurfacePoint> sample = thinned(surfaces, kSample);

  std::vector<float> shares(kDistances * kAngles * kFacings);
  float total = 0.0F;
  for (std::size_t i = 0; i < sample.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Eigen::Vector2f between = sample[i].position - sample[j].position;
      const float distance_m = between.norm();
      if (distance_m < kNearestM) continue;
      const auto step = static_cast<std::size_t>(distance_m / kStepM);
      if (step >= kDistances) continue;
      const std::size_t angle = quarter_of(sample[i].normal.dot(sample[j].normal));
      // -2: they face each other; 2: they turn their backs.
      const float away = (sample[i].normal - sample[j].normal).dot(between) / distance_m;
      const auto facing = static_cast<std::size_t>(std::clamp(away + 2.0F, 0.0F, 3.999F));
      shares[(step * kAngles + angle) * kFacings + facing] += 1.0F;
      total += 1.0F;
    }
  }
  if (total == 0.0F) return {};
  for (float& share : shares) share /= total;
  return shares;
}

double place_distance(std::span<const float> a, std::span<const float> b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return 0.5 * sum;
}

}  // namespace loopstone
