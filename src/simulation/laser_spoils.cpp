#include "simulation/laser_spoils.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

constexpr double kCoverNoise = 0.15;   ///< of the ring's width, standard deviation
constexpr double kDirtNearest = 0.02;  ///< [m]
constexpr double kDirtFarthest = 0.3;  ///< [m]
constexpr double kDirtEchoes = 0.5;    ///< share of spoilt beams that return from the dirt itself

/// What a log holds of a range: nearer than the laser can see is a bad beam.
float as_logged(double range_m, const LaserScan& scan) {
  if (range_m < scan.range_min_m) return std::numeric_limits<float>::quiet_NaN();
  return static_cast<float>(range_m);
}

}  // namespace

BlockedLaser::BlockedLaser(const RealismBlocked& options, Rng rng) : options_(options), rng_(rng) {
  for (double& size : sizes_) size = rng_.uniform(0.0, 0.5 / static_cast<double>(sizes_.size()));
  for (double& phase : phases_rad_) phase = rng_.uniform(0.0, 2.0 * kPi);
}

bool BlockedLaser::is_blocked(double time_s) const {
  return time_s >= options_.at_s && time_s < options_.at_s + options_.length_s;
}

/// From 0 (nearest) to 1.
double BlockedLaser::shape_at(double angle_rad) const {
  double shape = 0.5;
  for (std::size_t i = 0; i < sizes_.size(); ++i)
    shape += sizes_[i] * std::sin(static_cast<double>(i + 1) * angle_rad + phases_rad_[i]);
  return shape;
}

void BlockedLaser::spoil(LaserScan& scan, double time_s) {
  const bool blocked = is_blocked(time_s);
  const double width = options_.farthest_m - options_.nearest_m;
  for (std::size_t beam = 0; beam < scan.ranges_m.size(); ++beam) {
    const double noise = rng_.normal() * kCoverNoise;
    const bool is_seen = rng_.uniform() < options_.seen_share;
    if (!blocked || is_seen) continue;
    const double at = std::clamp(shape_at(scan.angle_rad(beam)) + noise, 0.0, 1.0);
    scan.ranges_m[beam] = as_logged(options_.nearest_m + at * width, scan);
  }
}

void DirtyWindow::spoil(LaserScan& scan) {
  for (std::size_t beam = 0; beam < scan.ranges_m.size(); ++beam) {
    const double chance = rng_.uniform();
    const double kind = rng_.uniform();
    const double range = rng_.uniform(kDirtNearest, kDirtFarthest);
    const double off = std::abs(wrap_angle(scan.angle_rad(beam) - options_.middle_rad));
    if (off > 0.5 * options_.width_rad || chance >= options_.share) continue;
    scan.ranges_m[beam] =
        kind < kDirtEchoes ? as_logged(range, scan) : std::numeric_limits<float>::infinity();
  }
}

}  // namespace loopstone
