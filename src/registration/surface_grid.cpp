#include "loopstone/registration/surface_grid.hpp"

#include <array>
#include <cassert>
#include <cmath>

namespace loopstone {

namespace {

/// What a point adds to a cell, all but where the cell is.
struct Addition {
  float weight;
  float normal_x;  // unit
  float normal_y;
  float weighted_x;  // weight * normal
  float weighted_y;
};

/// \param x, y  weight * offset from the cell's centre
inline void add_weighted(SurfaceCell& cell, const Addition& point, float x, float y) {
  for (SurfaceSum& sum : cell.sums) {
    if (sum.weight != 0.0F && !faces_like(sum, point.normal_x, point.normal_y)) continue;
    sum.weight += point.weight;
    sum.x += x;
    sum.y += y;
    sum.normal_x += point.weighted_x;
    sum.normal_y += point.weighted_y;
    return;
  }
}

Addition addition_of(const Eigen::Vector2f& normal, float weight) {
  return {weight, normal.x(), normal.y(), weight * normal.x(), weight * normal.y()};
}

/// Adds a point to its cell and the eight around it.
void add_point(BlockGrid<SurfaceCell>& level, const Eigen::Vector2d& point,
               const Eigen::Vector2f& normal, float weight) {
  constexpr int kSide = BlockGrid<SurfaceCell>::kBlockSide;
  const Cell middle = level.cell_of(point.x(), point.y());
  const Addition addition = addition_of(normal, weight);
  std::array<float, 3> x{};
  std::array<float, 3> y{};
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector2d centre = level.centre_of({middle.column + i - 1, middle.row + i - 1});
    const Eigen::Vector2d offset = point - centre;
    x[static_cast<std::size_t>(i)] = weight * static_cast<float>(offset.x());
    y[static_cast<std::size_t>(i)] = weight * static_cast<float>(offset.y());
  }
  // One look-up serves all nine where a block holds them.
  SurfaceCell* const together =
      BlockGrid<SurfaceCell>::is_inside_block(middle) ? &level.at(middle) : nullptr;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      SurfaceCell& cell = together != nullptr
                              ? together[(row - 1) * kSide + column - 1]
                              : level.at({middle.column + column - 1, middle.row + row - 1});
      add_weighted(cell, addition, x[static_cast<std::size_t>(column)],
                   y[static_cast<std::size_t>(row)]);
    }
  }
}

}  // namespace

void add_to(SurfaceCell& cell, const Eigen::Vector2d& offset, const Eigen::Vector2f& normal,
            float weight) {
  add_weighted(cell, addition_of(normal, weight), weight * static_cast<float>(offset.x()),
               weight * static_cast<float>(offset.y()));
}

SurfaceGrid::SurfaceGrid(std::span<const double> resolutions_m) {
  assert(!resolutions_m.empty());
  levels_.reserve(resolutions_m.size());
  for (const double resolution : resolutions_m) levels_.emplace_back(resolution);
}

void SurfaceGrid::insert(std::span<const SurfacePoint> points, const Pose2& grid_T_points) {
  const Eigen::Matrix2d rotation = grid_T_points.rotation();
  const Eigen::Vector2d translation = grid_T_points.translation();
  for (const SurfacePoint& surface : points) {
    const Eigen::Vector2d point = rotation * surface.position.cast<double>() + translation;
    const Eigen::Vector2f normal = (rotation * surface.normal.cast<double>()).cast<float>();
    for (auto& level : levels_) add_point(level, point, normal, surface.weight);
  }
}

}  // namespace loopstone
