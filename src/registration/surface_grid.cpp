#include "loopstone/registration/surface_grid.hpp"

#include <cassert>
#include <cmath>

namespace loopstone {

namespace {

/// Adds a point to its cell and the eight around it.
void add_point(BlockGrid<SurfaceCell>& level, const Eigen::Vector2d& point,
               const Eigen::Vector2f& normal, float weight) {
  const Cell middle = level.cell_of(point.x(), point.y());
  for (int row = middle.row - 1; row <= middle.row + 1; ++row) {
    for (int column = middle.column - 1; column <= middle.column + 1; ++column) {
      const Cell cell{column, row};
      add_to(level.at(cell), point - level.centre_of(cell), normal, weight);
    }
  }
}

}  // namespace

void add_to(SurfaceCell& cell, const Eigen::Vector2d& offset, const Eigen::Vector2f& normal,
            float weight) {
  for (SurfaceSum& sum : cell.sums) {
    if (sum.weight != 0.0F && !faces_like(sum, normal.x(), normal.y())) continue;
    sum.weight += weight;
    sum.x += weight * static_cast<float>(offset.x());
    sum.y += weight * static_cast<float>(offset.y());
    sum.normal_x += weight * normal.x();
    sum.normal_y += weight * normal.y();
    return;
  }
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
