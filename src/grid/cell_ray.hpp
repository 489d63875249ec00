#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "loopstone/grid/grid_frame.hpp"
#include "loopstone/grid/ray.hpp"

// One walk for all casters. Where a ray crosses an edge is computed from the edge, never by adding
// up, so a walk that starts midway crosses the edges ahead at the same distances, to the bit, as
// the walk of the whole ray.
namespace loopstone {

inline constexpr double kNoRange = std::numeric_limits<double>::infinity();

/// A ray counted in cells from the grid's lower left corner, and the part of it that can hit
/// something.
struct CellRay {
  double x = 0.0;
  double y = 0.0;
  double dx = 0.0;
  double dy = 0.0;
  double inverse_x = 0.0;  ///< 1 / dx; +inf when the ray runs along y
  double inverse_y = 0.0;
  double begin = 0.0;  ///< 0, or where the ray comes in from outside
  double end = -1.0;   ///< below begin: it misses the grid
};

/// The grid's extent and what turns metres into cells, ready for many rays.
struct CellRaySpace {
  double origin_x = 0.0;
  double origin_y = 0.0;
  double resolution = 0.05;
  double width = 0.0;   ///< [cells]
  double height = 0.0;  ///< [cells]
  double reach = 0.0;   ///< greatest range [cells]

  CellRaySpace(const GridFrame& frame, double max_range_m)
      : origin_x(frame.origin.x()),
        origin_y(frame.origin.y()),
        resolution(frame.resolution),
        width(frame.columns),
        height(frame.rows),
        reach(max_range_m / frame.resolution) {}

  [[nodiscard]] CellRay ray(double x_m, double y_m, double dx, double dy) const {
    // Less than a thousandth of a cell in a million of them: along the axis. It keeps 0 * inf out
    // of the walk.
    constexpr double kAlongAxis = 1e-9;
    if (std::abs(dx) < kAlongAxis) dx = 0.0;
    if (std::abs(dy) < kAlongAxis) dy = 0.0;
    CellRay ray{.x = (x_m - origin_x) / resolution,
                .y = (y_m - origin_y) / resolution,
                .dx = dx,
                .dy = dy,
                .inverse_x = 1.0 / dx,
                .inverse_y = 1.0 / dy,
                .begin = 0.0,
                .end = reach};
    clip(ray.x, ray.inverse_x, width, ray);
    clip(ray.y, ray.inverse_y, height, ray);
    return ray;
  }

 private:
  /// Half a cell around the grid is open ground, so that no rounding matters where the ray comes
  /// in.
  static void clip(double from, double inverse, double size, CellRay& ray) {
    constexpr double kBorder = 0.5;
    const double low = -kBorder - from;
    const double high = size + kBorder - from;
    if (std::abs(inverse) == kNoRange) {
      if (!(low <= 0.0 && high >= 0.0)) ray.end = -1.0;
      return;
    }
    const double one = low * inverse;
    const double other = high * inverse;
    // Not a number or not a direction: it hits nothing.
    if (!(std::abs(inverse) >= 0.5 && std::abs(one) < kNoRange && std::abs(other) < kNoRange)) {
      ray.end = -1.0;
      return;
    }
    ray.begin = std::max(ray.begin, std::min(one, other));
    ray.end = std::min(ray.end, std::max(one, other));
  }
};

/// Bytes of a grid with a border of one cell, so that a clipped ray never leaves them.
struct BorderedCells {
  std::int64_t pitch = 0;
  std::vector<std::uint8_t> bytes{};

  BorderedCells() = default;
  BorderedCells(const GridFrame& frame, std::uint8_t value)
      : pitch(std::int64_t{frame.columns} + 2),
        bytes(static_cast<std::size_t>(pitch) * (static_cast<std::size_t>(frame.rows) + 2), value) {
  }
  /// From -1 to columns, -1 to rows.
  [[nodiscard]] std::int64_t index_of(std::int64_t column, std::int64_t row) const {
    return (row + 1) * pitch + column + 1;
  }
};

/// A walk from cell to cell of a ray.
/// Source: Amanatides and Woo 1987, "A fast voxel traversal algorithm for ray tracing".
class CellWalk {
 public:
  /// Stands in the cell where the ray is at distance t [cells].
  CellWalk(const CellRay& ray, double t, const BorderedCells& cells)
      : x_(ray.x),
        y_(ray.y),
        inverse_x_(ray.inverse_x),
        inverse_y_(ray.inverse_y),
        right_(ray.dx >= 0.0),
        up_(ray.dy >= 0.0),
        row_step_(up_ ? cells.pitch : -cells.pitch),
        t_(t) {
    const double column = std::floor(ray.x + t * ray.dx);
    const double row = std::floor(ray.y + t * ray.dy);
    next_x_ = right_ ? column + 1.0 : column;
    next_y_ = up_ ? row + 1.0 : row;
    index_ = cells.index_of(static_cast<std::int64_t>(column), static_cast<std::int64_t>(row));
  }

  /// Where the ray came into this cell [cells].
  [[nodiscard]] double t() const { return t_; }
  [[nodiscard]] std::size_t index() const { return static_cast<std::size_t>(index_); }

  /// On to the next cell, or false when that lies beyond `end`.
  [[nodiscard]] bool step(double end) {
    const double to_x = (next_x_ - x_) * inverse_x_;
    const double to_y = (next_y_ - y_) * inverse_y_;
    t_ = std::min(to_x, to_y);
    // Through a corner: both at once when both are entered alike, else the axis that runs towards +
    // comes first.
    const bool x_first = to_x < to_y || (to_x == to_y && (right_ || !up_));
    const bool y_first = to_y < to_x || (to_x == to_y && (up_ || !right_));
    next_x_ += x_first ? (right_ ? 1.0 : -1.0) : 0.0;
    next_y_ += y_first ? (up_ ? 1.0 : -1.0) : 0.0;
    index_ += (x_first ? (right_ ? 1 : -1) : 0) + (y_first ? row_step_ : 0);
    return t_ <= end;
  }

 private:
  double x_;
  double y_;
  double inverse_x_;
  double inverse_y_;
  double next_x_ = 0.0;
  double next_y_ = 0.0;
  bool right_;
  bool up_;
  std::int64_t row_step_;
  std::int64_t index_ = 0;
  double t_;
};

}  // namespace loopstone
