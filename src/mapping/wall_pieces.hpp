#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "loopstone/grid/block_grid.hpp"
#include "loopstone/mapping/map_quality.hpp"
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

/// Joins the returns of a stretch's scans to pieces: each cell of 10 cm takes the mean of everything within 1.5 cells that faces
/// the same way, if at least two scans saw it and the mean lies in the cell.
[[nodiscard]] StretchWalls stretch_walls(std::span<const JudgedScan> scans);

/// All pieces, to be found by place.
class PieceIndex {
 public:
  explicit PieceIndex(std::vector<WallPiece> pieces);

  [[nodiscard]] const std::vector<WallPiece>& pieces() const { return pieces_; }
  /// Of a piece that a visit was called with, its place in pieces().
  [[nodiscard]] std::size_t position_of(const WallPiece& piece) const {
    return static_cast<std::size_t>(&piece - pieces_.data());
  }
  [[nodiscard]] Cell cell_of(const Eigen::Vector2f& point) const {
    return grid_.cell_of(static_cast<double>(point.x()), static_cast<double>(point.y()));
  }
  /// Calls visit(piece) for the pieces of a cell.
  template <typename Visit>
  void for_each_in(Cell cell, Visit&& visit) const {
    const Run* run = grid_.find(cell);
    if (run == nullptr) return;
    for (std::int32_t i = run->first; i < run->end; ++i)
      visit(pieces_[static_cast<std::size_t>(i)]);
  }
  /// The same for all cells within `reach` cells.
  template <typename Visit>
  void for_each_around(Cell centre, int reach, Visit&& visit) const {
    for (int row = centre.row - reach; row <= centre.row + reach; ++row) {
      for (int column = centre.column - reach; column <= centre.column + reach; ++column)
        for_each_in({column, row}, visit);
    }
  }

 private:
  struct Run {
    std::int32_t first = 0;
    std::int32_t end = 0;
  };
  std::vector<WallPiece> pieces_;  ///< by cell, in a cell by stretch
  BlockGrid<Run> grid_{kPieceM};
};

}  // namespace loopstone
