#include "loopstone/mapping/visit_coverage.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/grid/grid_cells.hpp"

namespace loopstone {

namespace {

double days_between(Stamp from, Stamp to) { return (to - from).seconds() / 86'400.0; }

}  // namespace

std::optional<double> VisitCoverage::days_since_seen(Cell cell) const {
  const std::size_t last = newest[cell];
  if (last == 0) return {};
  return days_between(begins[last - 1], begins.back());
}

double VisitCoverage::longest_days() const {
  double days = 0.0;
  for (const Stamp visit : begins) days = std::max(days, days_between(visit, begins.back()));
  return days;
}

VisitCoverage coverage_of(const VisitLedger& ledger, std::vector<Stamp> begins) {
  if (begins.size() != ledger.visits())
    throw UsageError("coverage_of: of each visit it must be known when it was");
  const Grid<CellVisits>& cells = ledger.cells();
  VisitCoverage coverage{.visits = Grid<std::uint16_t>(cells.frame()),
                         .newest = Grid<std::uint16_t>(cells.frame()),
                         .begins = std::move(begins)};
  for_each_cell(cells.frame(), [&](Cell cell) {
    coverage.visits[cell] = cells[cell].seen;
    coverage.newest[cell] = cells[cell].newest;
  });
  return coverage;
}

CoverageFigures figures_of(const VisitCoverage& coverage, const Grid<CellTravel>& travel,
                           const OccupancyMap& map) {
  const GridFrame& frame = map.observed.frame();
  std::size_t free = 0;
  std::size_t seen = 0;
  std::size_t driven = 0;
  for_each_cell(frame, [&](Cell cell) {
    if (!is_floor(map, cell)) return;
    ++free;
    seen += coverage.seen_by_newest(cell) ? 1 : 0;
    driven += travel[cell].passes > 0 ? 1 : 0;
  });
  const double cell_m2 = frame.resolution * frame.resolution;
  return {.free_m2 = static_cast<double>(free) * cell_m2,
          .free_seen_by_newest_m2 = static_cast<double>(seen) * cell_m2,
          .free_driven_m2 = static_cast<double>(driven) * cell_m2};
}

}  // namespace loopstone
