#pragma once

#include "loopstone/formats/image.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/pipeline/site.hpp"
#include "loopstone/report/site_figures.hpp"
#include "report/site_sheet.hpp"

// What is known of the cells of a site's map, on the map. 8-bit RGB.

namespace loopstone {

/// How many sessions saw the floor, how long ago, and where none drove.
[[nodiscard]] Image draw_coverage_picture(const SiteGrids& grids, const OccupancyMap& map,
                                          const SiteGround& ground);
/// How fast robots drove where.
/// \param figures  of the grids
[[nodiscard]] Image draw_travel_picture(const SiteGrids& grids, const SiteFigures& figures,
                                        const SiteGround& ground);
/// Surfaces that are suspected to be glass.
[[nodiscard]] Image draw_glass_picture(const SiteGrids& grids, const SiteGround& ground);

}  // namespace loopstone
