#include "loopstone/mapping/map_touch_up.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

namespace loopstone {

namespace {

/// Where the sides of a polygon meet the line of this y, in order.
std::vector<double> crossings(const Polygon2& polygon, double y) {
  std::vector<double> at;
  for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
    const Eigen::Vector2d& a = polygon.corners[i];
    const Eigen::Vector2d& b = polygon.corners[(i + 1) % polygon.corners.size()];
    // As contains() has it: a corner belongs to one of its two sides.
    if ((a.y() > y) == (b.y() > y)) continue;
    at.push_back(a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
  }
  std::ranges::sort(at);
  return at;
}

std::pair<Eigen::Vector2d, Eigen::Vector2d> box_around(std::span<const Polygon2> polygons) {
  constexpr double kFar = std::numeric_limits<double>::max();
  Eigen::Vector2d low(kFar, kFar);
  Eigen::Vector2d high(-kFar, -kFar);
  for (const Polygon2& polygon : polygons) {
    for (const Eigen::Vector2d& corner : polygon.corners) {
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
  return {low, high};
}

/// The part of a frame that a box touches; one cell at least.
GridFrame part_of(const GridFrame& frame, const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  const Cell from = frame.cell_of(low);
  const Cell to = frame.cell_of(high);
  const int left = std::clamp(from.column, 0, frame.columns - 1);
  const int below = std::clamp(from.row, 0, frame.rows - 1);
  GridFrame part = frame;
  part.columns = std::clamp(to.column, left, frame.columns - 1) - left + 1;
  part.rows = std::clamp(to.row, below, frame.rows - 1) - below + 1;
  part.origin = frame.origin + frame.resolution * Eigen::Vector2d(left, below);
  return part;
}

/// Of an occupied cell; of a free one the opposite.
float certain_log_odds(const OccupancyOptions& options) {
  const double p = options.clamp_probability;
  return static_cast<float>(std::log(p / (1.0 - p)));
}

}  // namespace

void for_each_cell_in(const Polygon2& polygon, const GridFrame& frame,
                      const std::function<void(Cell)>& visit) {
  for (int row = 0; row < frame.rows; ++row) {
    const std::vector<double> at = crossings(polygon, frame.centre_of({0, row}).y());
    for (std::size_t i = 0; i + 1 < at.size(); i += 2) {
      const int first = std::max(0, frame.cell_of({at[i], frame.origin.y()}).column);
      for (int column = first; column < frame.columns; ++column) {
        const double x = frame.centre_of({column, row}).x();
        if (x >= at[i + 1]) break;
        if (x >= at[i]) visit({column, row});
      }
    }
  }
}

void for_each_cell_touching(const Polygon2& polygon, const GridFrame& frame,
                            const std::function<void(Cell)>& visit) {
  Grid<std::uint8_t> touched(frame);
  for_each_cell_in(polygon, frame, [&](Cell cell) { touched[cell] = 1; });
  const std::size_t count = polygon.corners.size();
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector2d& from = polygon.corners[i];
    const Eigen::Vector2d way = polygon.corners[(i + 1) % count] - from;
    // Finely enough that a corner that is missed is a millimetre or so.
    constexpr double kStepCells = 0.05;
    const double steps = std::ceil(way.norm() / (kStepCells * frame.resolution));
    const int most = static_cast<int>(std::clamp(steps, 1.0, 1e7));
    for (int step = 0; step <= most; ++step) {
      const Cell cell = frame.cell_of(from + way * (static_cast<double>(step) / most));
      if (frame.contains(cell)) touched[cell] = 1;
    }
  }
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column)
      if (touched[{column, row}] != 0) visit({column, row});
  }
}

void crop(OccupancyMap& map, std::span<const Polygon2> polygons) {
  if (polygons.empty() || map.observed.empty()) return;
  const auto [low, high] = box_around(polygons);
  const GridFrame whole = map.observed.frame();
  const GridFrame part = part_of(whole, low, high);
  OccupancyMap cropped{Grid<float>(part), Grid<std::uint8_t>(part)};
  const auto left =
      static_cast<int>(std::lround((part.origin.x() - whole.origin.x()) / whole.resolution));
  const auto below =
      static_cast<int>(std::lround((part.origin.y() - whole.origin.y()) / whole.resolution));
  for (const Polygon2& polygon : polygons) {
    for_each_cell_in(polygon, part, [&](Cell cell) {
      const Cell from{cell.column + left, cell.row + below};
      cropped.log_odds[cell] = map.log_odds[from];
      cropped.observed[cell] = map.observed[from];
    });
  }
  map = std::move(cropped);
}

std::int64_t erase(OccupancyMap& map, const Polygon2& polygon, const OccupancyOptions& options) {
  const float free = -certain_log_odds(options);
  std::int64_t erased = 0;
  for_each_cell_in(polygon, map.observed.frame(), [&](Cell cell) {
    if (map.observed[cell] == 0 || map.log_odds[cell] < 0.0F) return;
    map.log_odds[cell] = free;
    ++erased;
  });
  return erased;
}

std::int64_t set_cells(OccupancyMap& map, const Polygon2& polygon, CellSetting setting,
                       const OccupancyOptions& options) {
  const float certain = certain_log_odds(options);
  std::int64_t cells = 0;
  const auto set = [&](Cell cell) {
    map.observed[cell] = setting == CellSetting::kUnknown ? 0 : 1;
    map.log_odds[cell] = setting == CellSetting::kUnknown    ? 0.0F
                         : setting == CellSetting::kOccupied ? certain
                                                             : -certain;
    ++cells;
  };
  const GridFrame& frame = map.observed.frame();
  if (setting == CellSetting::kOccupied) {
    for_each_cell_touching(polygon, frame, set);
  } else {
    for_each_cell_in(polygon, frame, set);
  }
  return cells;
}

}  // namespace loopstone
