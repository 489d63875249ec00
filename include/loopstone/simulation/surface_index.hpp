#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
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

/// The first surface along a ray.
struct SurfaceHit {
  static constexpr std::uint32_t kNothing = ~std::uint32_t{0};
  double range_m = std::numeric_limits<double>::infinity();
  std::uint32_t surface =
      kNothing;  ///< below the number of flat_surfaces: one of them; then the plan's circles
};

/// Answers exact range and distance queries on a floor plan by looking only at the surfaces near
/// the ray: each cell of a uniform grid knows the surfaces that cross it (Amanatides and Woo 1987,
/// "A fast voxel traversal algorithm"). Immutable, so it may be shared between threads.
class SurfaceIndex {
 public:
  explicit SurfaceIndex(const FloorPlan& plan, double cell_m = 0.5);

  /// Range to the first surface along the ray [m], exactly as the minimum over all surfaces; +inf
  /// beyond `max_range_m`.
  [[nodiscard]] double cast(const Eigen::Vector2d& origin, const Eigen::Vector2d& direction,
                            double max_range_m) const;

  /// The same, and which surface it is.
  [[nodiscard]] SurfaceHit hit(const Eigen::Vector2d& origin, const Eigen::Vector2d& direction,
                               double max_range_m) const;
  /// Range to one surface, as `hit` numbers them.
  [[nodiscard]] double range_to_surface(std::uint32_t surface, const Eigen::Vector2d& origin,
                                        const Eigen::Vector2d& direction) const;

  /// Distance to the nearest surface, or `limit_m` when nothing is nearer.
  [[nodiscard]] double distance(const Eigen::Vector2d& point, double limit_m) const;

 private:
  void for_each_in(Cell cell, auto&& visit) const;
  /// Calls visit(cell), which returns the nearest range so far, for the cells along a ray until
  /// none can hold a nearer surface.
  void walk(const Eigen::Vector2d& origin, const Eigen::Vector2d& direction, double max_range_m,
            auto&& visit) const;

  std::vector<Segment> segments_{};
  std::vector<Circle> circles_{};
  GridFrame frame_{};
  std::vector<std::uint32_t> first_{};     ///< of each cell in surfaces_, and one past the end
  std::vector<std::uint32_t> surfaces_{};  ///< below segments_.size(): a segment; else a circle
};

}  // namespace loopstone
