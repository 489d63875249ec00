#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/geometry/polygon.hpp"
#include "loopstone/grid/grid.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/slam/mapped_scan.hpp"

namespace loopstone {

/// Where a surface was met, from the side it was seen from.
struct WallSample {
  Eigen::Vector2f point;   ///< from WallSamples::origin [m], axes of the map
  Eigen::Vector2f normal;  ///< unit, towards free space
  std::int32_t scan = 0;   ///< which scan saw it; of cells: 0
};

/// What lines are laid through.
struct WallSamples {
  Eigen::Vector2d origin{0.0, 0.0};  ///< map frame [m]
  std::vector<WallSample> samples{};
  double common_sigma_m = 0.0;  ///< what all samples of a wall may have in common
  bool from_scans = false;
};

/// What the laser measured, at the poses of the finished map. Scans whose stamp the trajectory does
/// not have, and returns where the map has no occupied cell near, are left out: what a map has lost
/// by its filters and edits is no wall.
/// \param cells  100 occupied, 0 free, -1 unknown; as read_ros_map() gives them
/// \param robot_T_told  where the frame lies that the scans' mounts are told in: a map whose mount
///                      was corrected is of the robot's true centre
/// Cost: O(returns). The same for any number of threads.
[[nodiscard]] WallSamples samples_of_scans(std::span<const MappedScan* const> scans,
                                           const Trajectory& map_T_robot,
                                           const Grid<std::int8_t>& cells, Threads threads = {},
                                           const Pose2& robot_T_told = {});

/// The occupied cells that have a free neighbour, as samples of a surface that lies somewhere in
/// them.
[[nodiscard]] WallSamples samples_of_cells(const Grid<std::int8_t>& cells);

/// Adds the sides of walls that somebody drew by hand, as far as the map is free beside them, as if
/// enough scans had met them.
/// \param cells  with the walls
void add_walls(std::span<const Polygon2> walls, const Grid<std::int8_t>& cells,
               WallSamples& samples);

}  // namespace loopstone
