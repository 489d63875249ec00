#pragma once

#include <span>

#include "loopstone/plan/vector_plan.hpp"
#include "plan/floor_parts.hpp"

namespace loopstone {

/// A room from the cells of a part of the floor: its outline runs along the walls and the faces of
/// doors that bound it, and corners lie where those meet; where there are none it follows the
/// cells. Doors are left to others.
[[nodiscard]] PlanRoom outline_room(const FloorParts& parts, int part,
                                    std::span<const PlanSegment> segments,
                                    std::span<const DoorFace> faces);

}  // namespace loopstone
