#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "loopstone/geometry/polygon.hpp"
#include "loopstone/grid/grid.hpp"
#include "loopstone/grid/grid_frame.hpp"
#include "loopstone/mapping/occupancy.hpp"

// What a hand does to a drawn map. A cell lies in a polygon when its centre does.

namespace loopstone {

/// Visits the cells of a frame whose centres lie in a polygon, row by row. Cost: a look at each
/// row for each side, and one at each cell that is visited.
void for_each_cell_in(const Polygon2& polygon, const GridFrame& frame,
                      const std::function<void(Cell)>& visit);
/// The same, and the cells that its sides run through: nothing of the polygon is left out.
void for_each_cell_touching(const Polygon2& polygon, const GridFrame& frame,
                            const std::function<void(Cell)>& visit);

/// What lies in none of the polygons becomes unknown; the map shrinks to the box around them. A map
/// that has nothing there becomes one unknown cell.
void crop(OccupancyMap& map, std::span<const Polygon2> polygons);

/// What was seen in a polygon, occupied or in doubt, becomes free: the traces of people, of a cart
/// that is gone. What was never seen stays unknown. Returns how many cells changed from occupied or
/// in doubt.
std::int64_t erase(OccupancyMap& map, const Polygon2& polygon, const OccupancyOptions& options);

/// What a hand may say of cells.
enum class CellSetting { kFree, kOccupied, kUnknown };

/// The cells of a polygon are what they are told, whatever was seen there; occupied are also those
/// that its sides run through, so that thin walls hold. Returns how many lie on the map.
std::int64_t set_cells(OccupancyMap& map, const Polygon2& polygon, CellSetting setting,
                       const OccupancyOptions& options);

}  // namespace loopstone
