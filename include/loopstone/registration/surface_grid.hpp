#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/grid/block_grid.hpp"
#include "loopstone/sensor/scan_points.hpp"

namespace loopstone {

/// The mean of the surface points that fell in and next to a cell and face the same way. Position
/// is relative to the cell's centre; position and normal are sums of weight times value.
struct SurfaceSum {
  float weight = 0.0F;
  float x = 0.0F;
  float y = 0.0F;
  float normal_x = 0.0F;
  float normal_y = 0.0F;

  template <typename Archive>
  void archive(Archive& a) {
    a(weight, x, y, normal_x, normal_y);
  }
};

/// Two sums a cell, so that both sides of a thin wall and both walls of a corner stay apart.
struct SurfaceCell {
  std::array<SurfaceSum, 2> sums{};

  template <typename Archive>
  void archive(Archive& a) {
    a(sums);
  }
};

/// cos(60 deg): surfaces that face the same way may be the same.
inline constexpr float kSameSurfaceCosine = 0.5F;

/// Whether a sum faces like a unit normal, within the angle of that cosine (> 0). Compares squares,
/// so no root is needed.
[[nodiscard]] inline bool faces_like(const SurfaceSum& sum, float normal_x, float normal_y,
                                     float cosine = kSameSurfaceCosine) {
  const float dot = sum.normal_x * normal_x + sum.normal_y * normal_y;
  const float length2 = sum.normal_x * sum.normal_x + sum.normal_y * sum.normal_y;
  return dot > 0.0F && dot * dot > cosine * cosine * length2;
}

/// Adds a point to the cell's sum that faces the same way (within 60 deg), else to an empty one;
/// left out when there is neither. `offset` is from the cell's centre [m], `normal` is unit.
void add_to(SurfaceCell& cell, const Eigen::Vector2d& offset, const Eigen::Vector2f& normal,
            float weight);

/// The cell's sum that faces like a unit normal, or nullptr.
[[nodiscard]] inline const SurfaceSum* sum_facing(const SurfaceCell& cell, float normal_x,
                                                  float normal_y) {
  for (const SurfaceSum& sum : cell.sums) {
    if (sum.weight == 0.0F) return nullptr;
    if (faces_like(sum, normal_x, normal_y)) return &sum;
  }
  return nullptr;
}

/// A line in the plane: a point on it and its unit normal.
struct SurfaceLine {
  Eigen::Vector2d point;
  Eigen::Vector2d normal;
};

/// Surfaces of a place on grids of several resolutions, to align scans to. Each cell knows the line
/// through all points within 1.5 cells of its centre, so finding the surface near a point is a
/// single look-up. Compared with an occupancy grid of the same size, the line's position is not
/// rounded to cells. Related: Biber and Strasser 2003, "The Normal Distributions Transform";
/// Kohlbrecher 2011 for the grid levels.
class SurfaceGrid {
 public:
  /// Without a level: to be read from bytes.
  SurfaceGrid() = default;
  /// \param resolutions_m  finest first, at least one
  explicit SurfaceGrid(std::span<const double> resolutions_m);

  /// Adds points at a pose. Cost: 9 cells a point and level.
  void insert(std::span<const SurfacePoint> points, const Pose2& grid_T_points);

  [[nodiscard]] std::size_t level_count() const { return levels_.size(); }
  [[nodiscard]] double resolution_m(std::size_t level) const {
    return levels_[level].resolution_m();
  }

  /// The surface near a point that faces like `normal` (within 60 deg), if there is one. Cost:
  /// O(1). Here, so that a matcher's loop has it inline.
  [[nodiscard]] std::optional<SurfaceLine> line_near(std::size_t level,
                                                     const Eigen::Vector2d& point,
                                                     const Eigen::Vector2d& normal) const {
    const BlockGrid<SurfaceCell>& grid = levels_[level];
    const Cell at = grid.cell_of(point.x(), point.y());
    const SurfaceCell* cell = grid.find(at);
    if (cell == nullptr) return {};
    const SurfaceSum* sum =
        sum_facing(*cell, static_cast<float>(normal.x()), static_cast<float>(normal.y()));
    if (sum == nullptr) return {};
    const double mean = 1.0 / sum->weight;
    const Eigen::Vector2d total(sum->normal_x, sum->normal_y);
    return SurfaceLine{grid.centre_of(at) + Eigen::Vector2d(sum->x, sum->y) * mean,
                       total * (1.0 / std::sqrt(total.squaredNorm()))};
  }

  template <typename Archive>
  void archive(Archive& a) {
    a.list(levels_, [] { return BlockGrid<SurfaceCell>(1.0); });  // it brings its own resolution
  }

 private:
  std::vector<BlockGrid<SurfaceCell>> levels_{};
};

}  // namespace loopstone
