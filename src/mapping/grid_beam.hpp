#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "loopstone/grid/ray_walk.hpp"

namespace loopstone {

struct GridBeam {
  GridPoint start;
  GridPoint end;  ///< of what is free
  /// Where it ended, if it met something.
  std::optional<Cell> hit{};
  /// Where the walk begins, coming from the start: in the rows before, other beams cross the same
  /// cells.
  int walked_from_row = 0;
};

/// From the start to the end [cells].
[[nodiscard]] inline Eigen::Vector2d way_of(const GridBeam& beam) {
  const auto cells = [](std::int32_t from, std::int32_t to) {
    return static_cast<double>(std::int64_t{to} - from) / static_cast<double>(kGridPointsPerCell);
  };
  return {cells(beam.start.x, beam.end.x), cells(beam.start.y, beam.end.y)};
}

/// How far out [cells] every cell that `middle` crosses is crossed by a beam on its left or right,
/// too.
///
/// A cell that neither crosses lies in the wedge between the two, and fits only where that is at
/// least as wide as its side: width(distance) = angle * distance + what the lidar moved >= 1. It
/// may reach 1.42 cells beyond where `middle` crosses it.
[[nodiscard]] inline double shared_reach(const GridBeam& left, const GridBeam& middle,
                                         const GridBeam& right) {
  constexpr double kNarrowerThanCell = 0.95;  // less roundings, and sines for angles
  constexpr double kWidestSine = 0.3;
  constexpr double kCellReach = 1.5;
  const Eigen::Vector2d l = way_of(left);
  const Eigen::Vector2d m = way_of(middle);
  const Eigen::Vector2d r = way_of(right);
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  if (cross(l, m) * cross(m, r) < 0.0 || l.dot(r) <= 0.0 || l.dot(m) <= 0.0) return 0.0;
  const double l_length = l.norm();
  const double r_length = r.norm();
  const double sine = std::abs(cross(l, r)) / (l_length * r_length);
  if (!(sine < kWidestSine)) return 0.0;
  const auto moved = [&](const GridBeam& beam) {
    return way_of({middle.start, beam.start}).norm();
  };
  const double width = kNarrowerThanCell - moved(left) - moved(right);
  return std::min({width / std::max(sine, 1e-6), l_length, r_length}) - kCellReach;
}

/// Finds walked_from_row of a scan's beams, which are in the order of their angles: every other
/// beam begins where its neighbours part, every other of the rest where theirs do, and so on.
inline void skip_shared_rows(std::vector<GridBeam>& beams) {
  for (GridBeam& beam : beams) beam.walked_from_row = cell_of(beam.start).row;
  for (std::size_t step = 1; 2 * step < beams.size(); step *= 2) {
    for (std::size_t i = step; i + step < beams.size(); i += 2 * step) {
      GridBeam& beam = beams[i];
      const double reach = shared_reach(beams[i - step], beam, beams[i + step]);
      if (!(reach > 0.0)) continue;
      const Eigen::Vector2d way = way_of(beam);
      const double share = std::min(1.0, reach / std::max(way.norm(), 1e-6));
      const double y = beam.start.y + share * way.y() * static_cast<double>(kGridPointsPerCell);
      beam.walked_from_row = floor_to_int(y) >> kGridPointBits;
    }
  }
}

}  // namespace loopstone
