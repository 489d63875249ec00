#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/grid/grid.hpp"

namespace loopstone {

struct MapFieldOptions {
  double reach_m = 0.3;
  int levels = 3;
  int occupied_percent = 65;
};

template <typename Visitor>
void visit_options(MapFieldOptions& options, Visitor&& visit) {
  visit("reach_m", options.reach_m, Range{0.01, 10.0},
        "distances to walls grow up to here, on the finest level");
  visit("levels", options.levels, Range{1, 8}, "each with cells and reach twice the size");
  visit("occupied_percent", options.occupied_percent, Range{1, 100},
        "cells of this occupancy or more are walls");
}

/// The distance to the nearest wall near a place, and how it changes.
struct FieldSample {
  double distance_m = 0.0;             ///< no more than the level's reach
  Eigen::Vector2d gradient{0.0, 0.0};  ///< of the distance; zero where nothing is within reach
};

/// The walls of an occupancy grid as a smooth function of the place: the distance to the nearest
/// cell that a laser could have hit, cut off at a reach, interpolated between cell centres, on
/// several resolutions.
///
/// A laser sees the faces of solids, so only occupied cells beside a free one count (all of them
/// where nothing is free). Within its cell a face may be anywhere, so the cell's centre is the best
/// guess of it.
///
/// Memory: 5 bytes a cell, and a third more for the coarser levels. Cost to build: O(cells), about
/// 20 ns each.
/// Source: Kohlbrecher et al. 2011, "A flexible and scalable SLAM system with full 3D motion
/// estimation", section IV, for the levels and the interpolation; Thrun, Burgard and Fox 2005,
/// section 6.4, for distances in place of occupancies.
class MapField {
 public:
  /// What making one takes for each cell, about; what it keeps is less.
  static constexpr std::uint64_t kBytesPerCell = 15;

  /// \param occupancy  in percent, -1 unknown, as nav_msgs/OccupancyGrid has it
  explicit MapField(const Grid<std::int8_t>& occupancy, const MapFieldOptions& options = {});

  [[nodiscard]] std::size_t level_count() const { return levels_.size(); }
  [[nodiscard]] double resolution_m(std::size_t level) const {
    return levels_[level].frame().resolution;
  }
  [[nodiscard]] double reach_m(std::size_t level) const {
    return reach_m_ * static_cast<double>(1U << level);
  }
  /// Of the map that it was built from.
  [[nodiscard]] const GridFrame& frame() const { return levels_.front().frame(); }
  /// Of the finest level: from each cell's centre to the nearest wall, up to the coarsest level's
  /// reach [m].
  [[nodiscard]] const Grid<float>& distances() const { return levels_.front(); }
  [[nodiscard]] std::size_t memory_bytes() const;

  /// Bilinear between the centres of cells; the gradient is that of the interpolation, exactly.
  /// Cost: O(1). Outside the grid there are no walls.
  [[nodiscard]] FieldSample sample(std::size_t level, const Eigen::Vector2d& point) const;

  /// The unit normal of the wall nearest to a point, on the side where its gradient points, by the
  /// cells of the wall some decimetres around: its steps from row to row of cells are not the
  /// wall's. The gradient where nothing there looks like a wall.
  /// \param sample  of the finest level, at the point
  [[nodiscard]] Eigen::Vector2d wall_normal(const Eigen::Vector2d& point,
                                            const FieldSample& sample) const;

 private:
  double reach_m_;
  std::vector<Grid<float>> levels_{};
  Grid<std::uint8_t> normals_;  ///< of walls, in degrees and one [1, 180]; 0: none
};

/// The cells that a laser can have hit: occupied ones that touch a free cell, by a side or a
/// corner; every occupied cell where the map shows nothing free.
[[nodiscard]] Grid<std::uint8_t> visible_walls(const Grid<std::int8_t>& occupancy,
                                               int occupied_percent);

/// The centres of those cells, row by row [m].
[[nodiscard]] std::vector<Eigen::Vector2d> wall_points(
    const Grid<std::int8_t>& occupancy, int occupied_percent = MapFieldOptions{}.occupied_percent);

}  // namespace loopstone
