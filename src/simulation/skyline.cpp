#include "simulation/skyline.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace loopstone {

Skyline::Skyline(const SurfaceIndex& surfaces, const std::vector<Circle>& legs,
                 const Eigen::Vector2d& origin, double first_bearing_rad, double step_rad,
                 int bearings, double max_range_m)
    : surfaces_(surfaces), legs_(legs), origin_(origin), max_range_m_(max_range_m) {
  hits_.reserve(static_cast<std::size_t>(bearings));
  for (int i = 0; i < bearings; ++i) {
    const double bearing = first_bearing_rad + i * step_rad;
    hits_.push_back(look({std::cos(bearing), std::sin(bearing)}));
  }
}

double Skyline::range_to_surface(std::uint32_t surface, const Eigen::Vector2d& direction) const {
  if (surface == SurfaceHit::kNothing) return SurfaceHit{}.range_m;
  if (surface >= kFirstLeg) return range_to(legs_[surface - kFirstLeg], origin_, direction);
  return surfaces_.range_to_surface(surface, origin_, direction);
}

SurfaceHit Skyline::look(const Eigen::Vector2d& direction) const {
  SurfaceHit nearest = surfaces_.hit(origin_, direction, max_range_m_);
  for (std::size_t i = 0; i < legs_.size(); ++i) {
    const double range = range_to(legs_[i], origin_, direction);
    if (range < nearest.range_m) nearest = {range, kFirstLeg + static_cast<std::uint32_t>(i)};
  }
  return nearest.range_m <= max_range_m_ ? nearest : SurfaceHit{};
}

SurfaceHit Skyline::nearer_than(float limit_m, float bearing,
                                const Eigen::Vector2d& direction) const {
  const auto limit = static_cast<double>(limit_m);
  const auto i = static_cast<std::size_t>(bearing);
  const SurfaceHit& left = hits_[i];
  const SurfaceHit& right = hits_[i + 1];
  SurfaceHit found;
  if (left.surface == right.surface) {
    // Between two bearings so close a surface comes no nearer than this.
    if (limit < 0.999 * std::min(left.range_m, right.range_m)) return {};
    found = {range_to_surface(left.surface, direction), left.surface};
    if (left.surface == SurfaceHit::kNothing) return {};
  } else {
    found = {range_to_surface(left.surface, direction), left.surface};
    const double other = range_to_surface(right.surface, direction);
    if (other < found.range_m) found = {other, right.surface};
  }
  // An end of a surface lies between the bearings: whatever is behind it shows.
  if (!std::isfinite(found.range_m)) found = look(direction);
  return found.range_m < limit ? found : SurfaceHit{};
}

}  // namespace loopstone
