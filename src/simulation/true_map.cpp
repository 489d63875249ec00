#include <cmath>
#include <vector>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/simulation/world.hpp"

namespace loopstone {
namespace {

constexpr double kMargin = 0.5;
constexpr std::int8_t kUnknown = -1;
constexpr std::int8_t kFree = 0;
constexpr std::int8_t kOccupied = 100;

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

/// Occupied where a solid comes within half a cell of the cell's centre, unknown elsewhere.
Grid<std::int8_t> rasterise(const FloorPlan& plan, double resolution_m) {
  const Extent extent = extent_of(plan);
  Grid<std::int8_t> solid(frame_covering(extent.low, extent.high, resolution_m, kMargin), kUnknown);
  const GridFrame& frame = solid.frame();
  // A face that lies exactly between two rows of cells belongs to the row of its solid.
  const double reach = 0.5 * resolution_m * (1.0 - 1e-6);
  const auto mark_near = [&](const auto& surface, const Eigen::Vector2d& low,
                             const Eigen::Vector2d& high) {
    for_cells_in(frame, low.array() - resolution_m, high.array() + resolution_m, [&](Cell cell) {
      if (distance_to(surface, frame.centre_of(cell)) < reach) solid[cell] = kOccupied;
    });
  };
  for (const Segment& s : flat_surfaces(plan))
    mark_near(s, s.from.cwiseMin(s.to), s.from.cwiseMax(s.to));
  for (const Circle& c : plan.circles) {
    const Eigen::Vector2d low = c.centre.array() - c.radius_m;
    const Eigen::Vector2d high = c.centre.array() + c.radius_m;
    mark_near(c, low, high);
    for_cells_in(frame, low, high, [&](Cell cell) {
      if (is_inside(c, frame.centre_of(cell))) solid[cell] = kOccupied;
    });
  }
  for (const Box& box : plan.boxes) {
    const double reach_of_box = 0.5 * hypotenuse(box.length_m, box.width_m);
    const Eigen::Vector2d centre = box.map_T_box.translation();
    for_cells_in(frame, centre.array() - reach_of_box, centre.array() + reach_of_box,
                 [&](Cell cell) {
                   if (is_inside(box, frame.centre_of(cell))) solid[cell] = kOccupied;
                 });
  }
  return solid;
}

}  // namespace

Grid<std::int8_t> true_map(const World& world, double resolution_m) {
  if (world.given_map) return *world.given_map;
  Grid<std::int8_t> map = rasterise(world.plan, resolution_m);
  const GridFrame& frame = map.frame();
  std::vector<Cell> open{frame.cell_of(world.map_T_start.translation())};
  while (!open.empty()) {
    const Cell cell = open.back();
    open.pop_back();
    if (!frame.contains(cell) || map[cell] != kUnknown) continue;
    map[cell] = kFree;
    open.push_back({cell.column + 1, cell.row});
    open.push_back({cell.column - 1, cell.row});
    open.push_back({cell.column, cell.row + 1});
    open.push_back({cell.column, cell.row - 1});
  }
  return map;
}

}  // namespace loopstone
