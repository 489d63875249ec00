#include <cmath>

#include "loopstone/base/error.hpp"
#include "loopstone/simulation/world.hpp"
#include "simulation/route_planner.hpp"

namespace loopstone {
namespace {

using CellStates = Grid<std::int8_t>;

constexpr std::int8_t kOccupied = 65;  ///< [%], map_server's occupied_thresh

/// 1 for cells that are not known to be free; everything beyond the map is solid too.
bool is_solid(const CellStates& map, Cell cell) {
  const std::int8_t occupancy = map.value_or(cell, -1);
  return occupancy < 0 || occupancy >= kOccupied;
}

/// The borders between free and solid cells, neighbouring ones joined to one surface. So ranges in
/// the world are exact for the map's cells.
std::vector<Segment> borders(const CellStates& map) {
  const GridFrame& frame = map.frame();
  const auto corner = [&](int column, int row) {
    return Eigen::Vector2d(frame.origin + frame.resolution * Eigen::Vector2d(column, row));
  };
  std::vector<Segment> segments;
  // Horizontal borders below row `row`, then vertical ones left of column `column`.
  for (int row = 0; row <= frame.rows; ++row) {
    int from = -1;
    for (int column = 0; column <= frame.columns; ++column) {
      const bool is_border = column < frame.columns &&
                             is_solid(map, {column, row}) != is_solid(map, {column, row - 1});
      if (is_border && from < 0) from = column;
      if (!is_border && from >= 0) {
        segments.push_back({corner(from, row), corner(column, row)});
        from = -1;
      }
    }
  }
  for (int column = 0; column <= frame.columns; ++column) {
    int from = -1;
    for (int row = 0; row <= frame.rows; ++row) {
      const bool is_border =
          row < frame.rows && is_solid(map, {column, row}) != is_solid(map, {column - 1, row});
      if (is_border && from < 0) from = row;
      if (!is_border && from >= 0) {
        segments.push_back({corner(column, from), corner(column, row)});
        from = -1;
      }
    }
  }
  return segments;
}

}  // namespace

World make_world(const CellStates& map, const std::string& name, double robot_radius_m) {
  World world;
  world.name = name;
  world.plan.surfaces = borders(map);
  world.given_map = map;
  const auto refuse = [&] {
    return UsageError("map '" + name + "' has no free space for a robot of radius " +
                      std::to_string(robot_radius_m) + " m");
  };
  if (world.plan.surfaces.empty()) throw refuse();
  const SurfaceIndex obstacles(world.plan);
  RoutePlanner planner(obstacles, extent_of(world.plan), robot_radius_m + 0.1);
  const auto start = planner.reach_largest_region(
      [&](const Eigen::Vector2d& point) { return !is_solid(map, map.frame().cell_of(point)); });
  if (!start) throw refuse();
  world.map_T_start = {start->x(), start->y(), 0.0};
  world.places = planner.spread_points(4.0);
  for (std::size_t i = 0; i < world.places.size(); i += 7) world.returns.push_back(world.places[i]);
  world.returns.push_back(*start);
  const double cell_area = map.frame().resolution * map.frame().resolution;
  for (int row = 0; row < map.frame().rows; ++row) {
    for (int column = 0; column < map.frame().columns; ++column) {
      if (!is_solid(map, {column, row})) world.floor_area_m2 += cell_area;
    }
  }
  return world;
}

}  // namespace loopstone
