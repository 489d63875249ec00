#pragma once

#include <span>
#include <string>

#include "loopstone/formats/image.hpp"
#include "loopstone/grid/grid.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/mapping/visit_ledger.hpp"

namespace loopstone {

/// What appeared and what is gone, framed on the map of the later date. 8-bit RGB.
[[nodiscard]] Image draw_changes_picture(std::span<const MapChange> changes,
                                         const OccupancyMap& before, const OccupancyMap& now);
/// Where visits are not of one mind, on the map. 8-bit RGB.
[[nodiscard]] Image draw_movable_picture(const Grid<float>& movable, const OccupancyMap& map);

/// changes.png and changes.csv, into a folder that is made where it is missing. Throws DataError;
/// UsageError when the folder holds something.
/// \param force  what it holds may be replaced
void write_changes(std::span<const MapChange> changes, const OccupancyMap& before,
                   const OccupancyMap& now, const std::string& folder, bool force = false);
/// movable.png, and movable.pgm with movable.yaml: 0 to 100 % by map_server's mode raw.
void write_movable(const Grid<float>& movable, const OccupancyMap& map, const std::string& folder);

}  // namespace loopstone
