#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/grid/grid.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/mapping/travel.hpp"
#include "loopstone/mapping/visit_ledger.hpp"

namespace loopstone {

/// Who saw what of a building, and how long ago.
struct VisitCoverage {
  Grid<std::uint16_t> visits{};  ///< that saw a cell, occupied or free
  Grid<std::uint16_t> newest{};  ///< visit that saw it last, counted from 1; 0: none did
  std::vector<Stamp> begins{};   ///< when each visit was

  /// From the visit that saw a cell last to the newest visit [days]; nothing: no visit saw it.
  [[nodiscard]] std::optional<double> days_since_seen(Cell cell) const;
  /// From the oldest visit to the newest one.
  [[nodiscard]] double longest_days() const;
  [[nodiscard]] bool seen_by_newest(Cell cell) const { return newest[cell] == begins.size(); }
};

/// \param begins  when each visit was, in the order in which they were added; throws UsageError
///                where there are more or fewer
/// Cost: O(cells).
[[nodiscard]] VisitCoverage coverage_of(const VisitLedger& ledger, std::vector<Stamp> begins);

/// Of the floor that is free on a map [m^2].
struct CoverageFigures {
  double free_m2 = 0.0;
  double free_seen_by_newest_m2 = 0.0;
  double free_driven_m2 = 0.0;  ///< some robot's footprint came over it

  [[nodiscard]] double free_never_driven_m2() const { return free_m2 - free_driven_m2; }
};

/// All of the same frame. Cost: O(cells).
[[nodiscard]] CoverageFigures figures_of(const VisitCoverage& coverage,
                                         const Grid<CellTravel>& travel, const OccupancyMap& map);

/// Whether a cell of a map is floor: seen, and more likely free than not.
[[nodiscard]] inline bool is_floor(const OccupancyMap& map, Cell cell) {
  return map.observed[cell] != 0 && map.log_odds[cell] < 0.0F;
}

}  // namespace loopstone
