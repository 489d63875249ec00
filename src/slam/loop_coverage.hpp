#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
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

/// What surfaces are laid over: a submap's grids, built once for all of them.
struct SubmapGrids {
  const MaxPyramid& cells;
  const SurfaceGrid& surfaces;
};

/// A surface that falls where a submap was observed, in the frame of that one.
struct LaidSurface {
  std::size_t index;  ///< of the surfaces that are laid over it
  Eigen::Vector2d point;
  Eigen::Vector2d normal;
  std::optional<SurfaceLine> line;  ///< the submap's own near it that faces the same way
};

/// Tells of each surface that falls where a submap was observed. Near one that faces elsewhere,
/// such as the other side of a thin wall, nothing is told.
/// \param tell  is given each LaidSurface; without a line it lies in free space
template <typename Tell>
void lay_on(std::span<const SurfacePoint> surfaces, const SubmapGrids& target,
            const Pose2& target_T_source, Tell&& tell) {
  const Eigen::Matrix2d turn = target_T_source.rotation();
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const Eigen::Vector2d point = target_T_source * surfaces[i].position.cast<double>().eval();
    const Cell cell = target.cells.frame().cell_of(point);
    const std::uint8_t value = target.cells.bound(0, cell.column, cell.row);
    if (value == kUnknown) continue;
    const Eigen::Vector2d normal = turn * surfaces[i].normal.cast<double>();
    const auto line = target.surfaces.line_near(0, point, normal);
    if (!line && value > kUnknown) continue;
    tell(LaidSurface{i, point, normal, line});
  }
}

/// Which of the surfaces a submap shows as well: those that lay_on tells of.
[[nodiscard]] inline std::vector<bool> shown_by(const SubmapGrids& target,
                                                const Pose2& target_T_source,
                                                std::span<const SurfacePoint> surfaces) {
  std::vector<bool> shown(surfaces.size());
  lay_on(surfaces, target, target_T_source,
         [&](const LaidSurface& laid) { shown[laid.index] = true; });
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
