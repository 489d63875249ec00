#pragma once

#include <span>
#include <string>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/pipeline/site.hpp"
#include "loopstone/report/site_figures.hpp"

namespace loopstone {

/// \param edits  that the map was drawn with
/// Cost: O(cells).
[[nodiscard]] SiteFigures figures_of(const SiteGrids& grids, const OccupancyMap& map,
                                     std::span<const SiteCorrection> edits = {});

/// Into a folder that is made where it is missing; grids by map_server's mode raw, each as NAME.pgm
/// with NAME.yaml, 255 where nothing is known and 100 for more than that:
///
///   movable        as write_movable() has it
///   coverage       sessions that saw a cell, with coverage.png
///   coverage_days  from the session that saw it last to the newest one, in days, rounded up
///   travel         how often robots came by, of floor, with travel.png and travel.csv
///   glass          probability of glass [%], with glass.png
///
/// Throws DataError.
/// \param figures  of the grids and the map
/// \param movable  of the same cells
void write_site_grids(const SiteGrids& grids, const SiteFigures& figures,
                      const Grid<float>& movable, const OccupancyMap& map,
                      const std::string& folder, Threads threads);

}  // namespace loopstone
