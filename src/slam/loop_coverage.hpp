#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/grid/max_pyramid.hpp"
#include "loopstone/registration/correlative_search.hpp"
#include "loopstone/registration/surface_grid.hpp"

namespace loopstone {

/// Which of the surfaces fall where a submap was observed.
[[nodiscard]] inline std::vector<bool> seen_by(const MaxPyramid& target,
                                               const Pose2& target_T_source,
                                               std::span<const SurfacePoint> surfaces) {
  std::vector<bool> seen;
  seen.reserve(surfaces.size());
  for (const SurfacePoint& surface : surfaces) {
    const Cell cell =
        target.frame().cell_of(target_T_source * surface.position.cast<double>().eval());
    seen.push_back(target.bound(0, cell.column, cell.row) != kUnknown);
  }
  return seen;
}

/// Which of the surfaces a submap shows as well: those that fall where it was observed, but for the
/// other side of what it saw, such as that of a thin wall.
[[nodiscard]] inline std::vector<bool> shown_by(const MaxPyramid& target,
                                                const SurfaceGrid& target_surfaces,
                                                const Pose2& target_T_source,
                                                std::span<const SurfacePoint> surfaces) {
  const Eigen::Matrix2d turn = target_T_source.rotation();
  std::vector<bool> shown;
  shown.reserve(surfaces.size());
  for (const SurfacePoint& surface : surfaces) {
    const Eigen::Vector2d point = target_T_source * surface.position.cast<double>().eval();
    const Cell cell = target.frame().cell_of(point);
    const std::uint8_t value = target.bound(0, cell.column, cell.row);
    shown.push_back(
        value < kUnknown ||
        (value > kUnknown &&
         target_surfaces.line_near(0, point, turn * surface.normal.cast<double>()).has_value()));
  }
  return shown;
}

inline void add_to(std::vector<bool>& seen, const std::vector<bool>& more) {
  for (std::size_t i = 0; i < seen.size(); ++i) seen[i] = seen[i] || more[i];
}

[[nodiscard]] inline double share_of(const std::vector<bool>& seen) {
  return static_cast<double>(std::count(seen.begin(), seen.end(), true)) /
         static_cast<double>(seen.size());
}

}  // namespace loopstone
