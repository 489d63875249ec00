#include <cmath>
#include <vector>

#include "loopstone/simulation/world.hpp"

namespace loopstone {
namespace {

constexpr double kMargin = 0.5;
constexpr float kCertain = 3.5f;  ///< log odds of p = 0.97

/// Calls visit(cell) for the cells of a grid whose centres lie in a rectangle.
template <typename Visitor>
void for_cells_in(const GridFrame& frame, const Eigen::Vector2d& low, const Eigen::Vector2d& high,
                  Visitor&& visit) {
  const Cell first = frame.cell_of(low);
  const Cell last = frame.cell_of(high);
  for (int row = first.row; row <= last.row; ++row) {
    for (int column = first.column; column <= last.column; ++column) {
      if (frame.contains({column, row})) visit(Cell{column, row});
    }
  }
}

/// 1 where a solid comes within half a cell of the cell's centre.
Grid<std::uint8_t> rasterise(const FloorPlan& plan, double resolution_m) {
  const Extent extent = extent_of(plan);
  Grid<std::uint8_t> solid(frame_covering(extent.low, extent.high, resolution_m, kMargin));
  const GridFrame& frame = solid.frame();
  // A face that lies exactly between two rows of cells belongs to the row of its solid.
  const double reach = 0.5 * resolution_m * (1.0 - 1e-6);
  const auto mark_near = [&](const auto& surface, const Eigen::Vector2d& low,
                             const Eigen::Vector2d& high) {
    for_cells_in(frame, low.array() - resolution_m, high.array() + resolution_m, [&](Cell cell) {
      if (distance_to(surface, frame.centre_of(cell)) < reach) solid[cell] = 1;
    });
  };
  for (const Segment& s : flat_surfaces(plan))
    mark_near(s, s.from.cwiseMin(s.to), s.from.cwiseMax(s.to));
  for (const Circle& c : plan.circles) {
    const Eigen::Vector2d low = c.centre.array() - c.radius_m;
    const Eigen::Vector2d high = c.centre.array() + c.radius_m;
    mark_near(c, low, high);
    for_cells_in(frame, low, high, [&](Cell cell) {
      if (is_inside(c, frame.centre_of(cell))) solid[cell] = 1;
    });
  }
  for (const Box& box : plan.boxes) {
    const double reach_of_box = 0.5 * std::hypot(box.length_m, box.width_m);
    const Eigen::Vector2d centre = box.map_T_box.translation();
    for_cells_in(frame, centre.array() - reach_of_box, centre.array() + reach_of_box,
                 [&](Cell cell) {
                   if (is_inside(box, frame.centre_of(cell))) solid[cell] = 1;
                 });
  }
  return solid;
}

}  // namespace

OccupancyMap true_map(const World& world, double resolution_m) {
  if (world.given_map) return *world.given_map;
  const Grid<std::uint8_t> solid = rasterise(world.plan, resolution_m);
  const GridFrame& frame = solid.frame();
  OccupancyMap map{Grid<float>(frame, 0.0f), Grid<std::uint8_t>(frame, 0)};
  for (std::size_t i = 0; i < solid.cells().size(); ++i) {
    if (solid.cells()[i] == 0) continue;
    map.log_odds.cells()[i] = kCertain;
    map.observed.cells()[i] = 1;
  }
  std::vector<Cell> open{frame.cell_of(world.map_T_start.translation())};
  while (!open.empty()) {
    const Cell cell = open.back();
    open.pop_back();
    if (!frame.contains(cell) || map.observed[cell] != 0) continue;
    map.observed[cell] = 1;
    map.log_odds[cell] = -kCertain;
    open.push_back({cell.column + 1, cell.row});
    open.push_back({cell.column - 1, cell.row});
    open.push_back({cell.column, cell.row + 1});
    open.push_back({cell.column, cell.row - 1});
  }
  return map;
}

}  // namespace loopstone
