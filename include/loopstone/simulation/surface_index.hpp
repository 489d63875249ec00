#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "loopstone/grid/grid_frame.hpp"
#include "loopstone/simulation/floor_plan.hpp"

namespace loopstone {

/// Range along a ray to a surface [m]; +inf when the ray misses it. `direction` has unit length.
[[nodiscard]] double range_to(const Segment& segment, const Eigen::Vector2d& origin,
                              const Eigen::Vector2d& direction);
/// The nearer of the two crossings in front of the origin.
[[nodiscard]] double range_to(const Circle& circle, const Eigen::Vector2d& origin,
                              const Eigen::Vector2d& direction);

/// Answers exact range and distance queries on a floor plan by looking only at the surfaces near the ray: each cell of
/// a uniform grid knows the surfaces that cross it (Amanatides and Woo 1987, "A fast voxel traversal algorithm").
/// Immutable, so it may be shared between threads.
class SurfaceIndex {
 public:
  explicit SurfaceIndex(const FloorPlan& plan, double cell_m = 0.5);

  /// Range to the first surface along the ray [m], exactly as the minimum over all surfaces; +inf beyond `max_range_m`.
  [[nodiscard]] double cast(const Eigen::Vector2d& origin, const Eigen::Vector2d& direction,
                            double max_range_m) const;

  /// Distance to the nearest surface, or `limit_m` when nothing is nearer.
  [[nodiscard]] double distance(const Eigen::Vector2d& point, double limit_m) const;

 private:
  void for_each_in(Cell cell, auto&& visit) const;

  std::vector<Segment> segments_{};
  std::vector<Circle> circles_{};
  GridFrame frame_{};
  std::vector<std::uint32_t> first_{};     ///< of each cell in surfaces_, and one past the end
  std::vector<std::uint32_t> surfaces_{};  ///< below segments_.size(): a segment; else a circle
};

}  // namespace loopstone
