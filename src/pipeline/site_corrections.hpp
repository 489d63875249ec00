#pragma once

#include <span>
#include <vector>

#include "loopstone/grid/grid.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/pipeline/site.hpp"

namespace loopstone {

/// Sets the cells that edits speak of, in their order, and counts them.
void correct(OccupancyMap& map, const OccupancyOptions& options,
             std::vector<SiteCorrection>& edits);
/// What was said by hand does not move.
void settle(Grid<float>& movable, std::span<const SiteCorrection> edits);

}  // namespace loopstone
