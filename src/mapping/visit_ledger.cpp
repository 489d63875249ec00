#include "loopstone/mapping/visit_ledger.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "loopstone/base/error.hpp"
#include "loopstone/grid/grid_cells.hpp"
#include "mapping/cell_pieces.hpp"
#include "mapping/shared_grid.hpp"

namespace loopstone {

namespace {

/// From cells of one frame to those of another.
Cell shift_between(const GridFrame& from, const GridFrame& to) {
  const Cell a = corner_of(from);
  const Cell b = corner_of(to);
  return {a.column - b.column, a.row - b.row};
}

GridFrame joined(const GridFrame& a, const GridFrame& b) {
  const Cell low_a = corner_of(a);
  const Cell low_b = corner_of(b);
  const Cell low{std::min(low_a.column, low_b.column), std::min(low_a.row, low_b.row)};
  const Cell high{std::max(low_a.column + a.columns, low_b.column + b.columns),
                  std::max(low_a.row + a.rows, low_b.row + b.rows)};
  return {.origin = {low.column * a.resolution, low.row * a.resolution},
          .resolution = a.resolution,
          .columns = high.column - low.column,
          .rows = high.row - low.row};
}

/// Whether a visit saw a cell occupied or free; nothing when it did not see it well enough.
std::optional<bool> seen_occupied(const OccupancyMap& visit, Cell cell) {
  if (visit.observed[cell] == 0) return {};
  const double probability = visit.probability(cell);
  if (probability > kVisitLedger.occupied) return true;
  if (probability < kVisitLedger.free) return false;
  return {};
}

/// \param visit  counted from 1
void note(bool occupied, std::size_t visit, CellVisits& cell) {
  const bool agrees = cell.seen > 0 && cell.newest_is_occupied == occupied;
  cell.in_a_row = agrees ? static_cast<std::uint8_t>(std::min(cell.in_a_row + 1, 255)) : 1;
  cell.newest_is_occupied = occupied;
  // One mind so far, of one visit alone: the newer one is as good.
  const bool lone = cell.seen <= 1;
  constexpr int kMost = std::numeric_limits<std::uint16_t>::max();
  cell.newest = static_cast<std::uint16_t>(std::min<std::size_t>(visit, kMost));
  cell.seen = static_cast<std::uint16_t>(std::min(cell.seen + 1, kMost));
  if (occupied) cell.occupied = static_cast<std::uint16_t>(std::min(cell.occupied + 1, kMost));
  if (lone || cell.in_a_row >= kVisitLedger.believed_after) cell.is_occupied = occupied;
}

bool is_occupied(const OccupancyMap& map, Cell cell) {
  return map.observed.value_or(cell, 0) != 0 && map.probability(cell) > kVisitLedger.occupied;
}
bool is_free(const OccupancyMap& map, Cell cell) {
  return map.observed.value_or(cell, 0) != 0 && map.probability(cell) < kVisitLedger.free;
}

bool is_near_occupied(const OccupancyMap& map, Cell cell, int reach) {
  for (int row = cell.row - reach; row <= cell.row + reach; ++row) {
    for (int column = cell.column - reach; column <= cell.column + reach; ++column)
      if (map.observed.frame().contains({column, row}) && is_occupied(map, {column, row}))
        return true;
  }
  return false;
}

/// What is occupied in one map and was seen free, and far from anything, in the other.
void add_pieces(const OccupancyMap& there, const OccupancyMap& not_there, bool appeared,
                std::vector<MapChange>& changes) {
  const GridFrame& frame = there.log_odds.frame();
  const Cell shift = shift_between(frame, not_there.log_odds.frame());
  const int reach = static_cast<int>(std::ceil(kVisitLedger.changed_m / frame.resolution));
  Grid<std::uint8_t> marked(frame);
  for_each_cell(frame, [&](Cell cell) {
    const Cell other{cell.column + shift.column, cell.row + shift.row};
    if (!is_occupied(there, cell) || !not_there.observed.frame().contains(other)) return;
    if (is_free(not_there, other) && !is_near_occupied(not_there, other, reach)) marked[cell] = 1;
  });
  CellPieces pieces(marked,
                    static_cast<int>(std::ceil(kVisitLedger.changed_gap_m / frame.resolution)));
  pieces.for_each([&](const std::vector<Cell>& piece) {
    if (piece.size() < static_cast<std::size_t>(kVisitLedger.changed_cells)) return;
    MapChange change{.appeared = appeared};
    change.low.setConstant(std::numeric_limits<double>::infinity());
    change.high = -change.low;
    for (const Cell cell : piece) {
      const Eigen::Vector2d centre = frame.centre_of(cell);
      change.low = change.low.cwiseMin(centre);
      change.high = change.high.cwiseMax(centre);
    }
    const Eigen::Vector2d half = Eigen::Vector2d::Constant(0.5 * frame.resolution);
    change.low -= half;
    change.high += half;
    change.area_m2 = static_cast<double>(piece.size()) * frame.resolution * frame.resolution;
    changes.push_back(change);
  });
}

}  // namespace

void VisitLedger::cover(const GridFrame& frame) {
  if (cells_.empty()) {
    cells_ = Grid<CellVisits>(frame);
    return;
  }
  const GridFrame whole = joined(cells_.frame(), frame);
  if (whole.columns == cells_.frame().columns && whole.rows == cells_.frame().rows) return;
  Grid<CellVisits> larger(whole);
  const Cell shift = shift_between(cells_.frame(), whole);
  for_each_cell(cells_.frame(), [&](Cell cell) {
    larger[{cell.column + shift.column, cell.row + shift.row}] = cells_[cell];
  });
  cells_ = std::move(larger);
}

void VisitLedger::add(const OccupancyMap& visit) {
  const GridFrame& frame = visit.log_odds.frame();
  if (visit.log_odds.empty()) {
    ++visits_;
    return;
  }
  if (!lies_on_grid(frame) || (!cells_.empty() && cells_.frame().resolution != frame.resolution))
    throw UsageError("VisitLedger: the maps of all visits must share one grid");
  cover(frame);
  const Cell shift = shift_between(frame, cells_.frame());
  ++visits_;
  for_each_cell(frame, [&](Cell cell) {
    if (const auto occupied = seen_occupied(visit, cell))
      note(*occupied, visits_, cells_[{cell.column + shift.column, cell.row + shift.row}]);
  });
}

OccupancyMap VisitLedger::map() const {
  OccupancyMap map{Grid<float>(cells_.frame()), Grid<std::uint8_t>(cells_.frame())};
  for_each_cell(cells_.frame(), [&](Cell place) {
    const CellVisits& cell = cells_[place];
    if (cell.seen == 0) return;
    map.observed[place] = 1;
    // As many as agree with what is believed since somebody did not; one is enough for a map.
    const double agreeing = cell.newest_is_occupied == cell.is_occupied ? 1.0 + cell.in_a_row : 1.0;
    const double log_odds = std::min(1.0 + 0.5 * agreeing, 3.5);
    map.log_odds[place] = static_cast<float>(cell.is_occupied ? log_odds : -log_odds);
  });
  return map;
}

Grid<float> VisitLedger::movable() const {
  Grid<float> probability(cells_.frame());
  // Walls tremble by a cell or two from visit to visit.
  const int reach =
      static_cast<int>(std::ceil(kVisitLedger.trembles_m / cells_.frame().resolution));
  const auto is_near_fixed = [&](Cell place) {
    for (int row = place.row - reach; row <= place.row + reach; ++row) {
      for (int column = place.column - reach; column <= place.column + reach; ++column) {
        const CellVisits cell = cells_.value_or({column, row}, {});
        if (cell.occupied > 0 && cell.occupied >= kVisitLedger.fixed_share * cell.seen) return true;
      }
    }
    return false;
  };
  for_each_cell(cells_.frame(), [&](Cell place) {
    const CellVisits& cell = cells_[place];
    if (cell.occupied == 0 || cell.occupied == cell.seen || is_near_fixed(place)) return;
    // Of visits, one more of each kind at first: Laplace's rule of succession.
    probability[place] = static_cast<float>((cell.occupied + 1.0) / (cell.seen + 2.0));
  });
  return probability;
}

std::vector<MapChange> changes_between(const OccupancyMap& before, const OccupancyMap& now) {
  std::vector<MapChange> changes;
  if (before.log_odds.empty() || now.log_odds.empty()) return changes;
  add_pieces(now, before, true, changes);
  add_pieces(before, now, false, changes);
  std::ranges::stable_sort(changes, std::ranges::greater{}, &MapChange::area_m2);
  return changes;
}

}  // namespace loopstone
