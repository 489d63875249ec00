#pragma once

#include <Eigen/Core>
#include <cmath>
#include <span>
#include <vector>

#include "loopstone/mapping/map_quality.hpp"
#include "mapping/cell_runs.hpp"
#include "mapping/judged_scans.hpp"

namespace loopstone {

/// Length of a piece of wall, and side of the cells that index them.
inline constexpr double kPieceM = 0.1;
/// Walls that face the same way, within 25 deg.
inline constexpr float kSameFacing = 0.9F;

/// A short piece of wall as one stretch of travel saw it, map frame.
struct WallPiece {
  Eigen::Vector2f position;
  Eigen::Vector2f normal;  ///< unit, to the side it was seen from
  int stretch = 0;
};

/// Whether two stretches are different visits.
[[nodiscard]] inline bool are_apart(int a, int b) { return std::abs(a - b) >= kStretchesApart; }

/// What the scans of one stretch make of their surroundings.
struct StretchWalls {
  std::vector<WallPiece> pieces{};
  std::vector<float> spread_m{};  ///< of the scans' lines about the pieces, absolute values
};

/// Joins the returns of a stretch's scans to pieces: each cell of 10 cm takes the mean of
/// everything within 1.5 cells that faces the same way, if at least two scans saw it and the mean
/// lies in the cell.
[[nodiscard]] StretchWalls stretch_walls(std::span<const JudgedScan> scans);

/// All pieces, to be found by place; in a cell in the order of the stretches.
using PieceIndex = CellRuns<WallPiece>;

}  // namespace loopstone
