#pragma once

#include <Eigen/Core>
#include <cmath>
#include <span>
#include <vector>

#include "loopstone/mapping/map_quality.hpp"
#include "mapping/cell_runs.hpp"
#include "mapping/judged_scans.hpp"

namespace loopstone {

/// What pieces of wall are made by.
struct WallPieceNumbers {
  double piece_m = 0.1;
  double same_facing = 0.9;
  int least_scans = 2;
  double least_straightness = 0.97;
};
inline constexpr WallPieceNumbers kWallPieces{};

template <typename Visitor>
void visit_numbers(const WallPieceNumbers& n, Visitor&& visit) {
  visit("piece_m", n.piece_m,
        "chosen: length of a piece of wall, and side of the cells that index them");
  visit("same_facing", n.same_facing,
        "derived: cosine of 25 deg, within which walls face the same way");
  visit("least_scans", n.least_scans, "chosen: a wall that a single scan saw may be a passer-by");
  visit("least_straightness", n.least_straightness,
        "chosen: length of the mean normal, for a spread of about 14 deg; lines fitted around a "
        "corner face everywhere between its two walls");
}

/// The same as the points that are compared by it.
inline constexpr auto kSameFacing = static_cast<float>(kWallPieces.same_facing);

/// A short piece of wall as one stretch of travel saw it, map frame.
struct WallPiece {
  Eigen::Vector2f position;
  Eigen::Vector2f normal;  ///< unit, to the side it was seen from
  int stretch = 0;
};

/// How far a point lies before a piece of wall, on the side that it was seen from [m].
[[nodiscard]] inline float across(const WallPiece& piece, const Eigen::Vector2f& point) {
  return piece.normal.dot(point - piece.position);
}
/// How far along the wall a point lies from the middle of the piece, to the left as seen from the
/// wall [m].
[[nodiscard]] inline float along(const WallPiece& piece, const Eigen::Vector2f& point) {
  const Eigen::Vector2f offset = point - piece.position;
  return piece.normal.x() * offset.y() - piece.normal.y() * offset.x();
}

/// Whether two stretches are different visits.
[[nodiscard]] inline bool are_apart(int a, int b) {
  return std::abs(a - b) >= kMapQuality.stretches_apart;
}

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
