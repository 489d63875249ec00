#pragma once

#include <cstdint>

#include "loopstone/grid/grid.hpp"
#include "plan/wall_line.hpp"

namespace loopstone {

/// Tells walls from what stands before them. A wall is what has much surface in one plane, and what
/// is joined to walls on both ends, as jambs are; what stands free and is small is none.
void find_structure(const Grid<std::int8_t>& cells, JoinedSegments& joined);

/// The same for what was found since: other faces of walls, and what is joined to them.
void complete_structure(JoinedSegments& joined);

/// Adds wall that furniture hides: where a wall ends at a thing and goes on behind it, or meets
/// another one there.
void add_hidden_walls(const Grid<std::int8_t>& cells, JoinedSegments& joined);

}  // namespace loopstone
