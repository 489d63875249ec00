#pragma once

#include <cstdint>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/grid/grid.hpp"

namespace loopstone {

/// What a map says about a cell.
enum class CellState : std::uint8_t { kUnknown, kFree, kOccupied };

/// Cells that hold occupancy in percent, -1 where unknown (nav_msgs/OccupancyGrid): occupied from
/// 65 up, free up to 20 (the thresholds of map_server), unknown between.
[[nodiscard]] Grid<CellState> classify_cells(const Grid<std::int8_t>& occupancy_percent);

/// How well a map agrees with the true one.
struct MapScore {
  double precision =
      /// share of the map's occupied cells that have a true occupied cell within the tolerance
      0.0;
  double recall =
      0.0;  ///< share of the true surface cells that have an occupied cell within the tolerance
  double f1 = 0.0;               ///< harmonic mean of both
  double free_iou = 0.0;         ///< area free in both maps / area free in either
  double mean_distance_m = 0.0;  ///< from the map's occupied cells to the nearest true one
  double mean_gap_m = 0.0;  ///< from the true surface cells to the nearest occupied cell of the map
  std::int64_t occupied_cells = 0;  ///< of the map
  std::int64_t surface_cells = 0;   ///< of the true map
};

/// Compares a map with the true map. `truth_T_map` brings the map's coordinates to the true map's
/// (a map starts where the robot does); the maps may differ in resolution and extent.
///
/// A true occupied cell counts as surface only if one of its eight neighbours is free: nobody can
/// see the inside of a wall. Distances go from cell centre to cell centre and are capped at
/// `largest_distance_m`, so that an empty map does not score infinity. Scores without cells to
/// count are 0.
/// Cost: O(cells of both maps).
[[nodiscard]] MapScore score_map(const Grid<CellState>& map, const Grid<CellState>& truth,
                                 const Pose2& truth_T_map = {}, double tolerance_m = 0.1,
                                 double largest_distance_m = 1.0);

}  // namespace loopstone
