#include "loopstone/mapping/visit_coverage.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

constexpr double kCellM = 0.05;

/// Free from one cell to another, both included.
OccupancyMap visit(Cell low, Cell high) {
  const GridFrame frame{.origin = {low.column * kCellM, low.row * kCellM},
                        .resolution = kCellM,
                        .columns = high.column - low.column + 1,
                        .rows = high.row - low.row + 1};
  return {Grid<float>(frame, -2.0F), Grid<std::uint8_t>(frame, 1)};
}

Stamp day(double days) { return Stamp::from_seconds(86'400.0 * (20'000.0 + days)); }

TEST(VisitCoverage, TellsForEachCellWhoSawItAndWhen) {
  Rng rng(3);
  VisitLedger ledger;
  std::vector<Stamp> begins;
  std::vector<std::pair<Cell, Cell>> boxes;
  const auto cell = [&] { return static_cast<int>(rng.uniform(0.0, 40.0)); };
  for (int i = 0; i < 9; ++i) {
    const Cell low{cell() - 20, cell() - 20};
    boxes.emplace_back(low, Cell{low.column + cell(), low.row + cell()});
    ledger.add(visit(boxes.back().first, boxes.back().second));
    begins.push_back(day(1.5 * i * i));
  }
  const VisitCoverage coverage = coverage_of(ledger, begins);
  const GridFrame& frame = coverage.visits.frame();
  const Cell corner{static_cast<int>(std::lround(frame.origin.x() / kCellM)),
                    static_cast<int>(std::lround(frame.origin.y() / kCellM))};
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      int visits = 0;
      std::optional<double> since;
      for (std::size_t i = 0; i < boxes.size(); ++i) {
        const auto& [low, high] = boxes[i];
        const Cell at{column + corner.column, row + corner.row};
        if (at.column < low.column || at.column > high.column || at.row < low.row ||
            at.row > high.row)
          continue;
        ++visits;
        since = (begins.back() - begins[i]).seconds() / 86'400.0;
      }
      EXPECT_EQ(coverage.visits[(Cell{column, row})], visits);
      EXPECT_EQ(coverage.days_since_seen({column, row}), since);
      EXPECT_EQ(coverage.seen_by_newest({column, row}), since == 0.0);
    }
  }
  EXPECT_THROW((void)coverage_of(ledger, {day(1.0)}), UsageError);
}

TEST(VisitCoverage, FiguresAreOfTheFreeFloor) {
  VisitLedger ledger;
  ledger.add(visit({0, 0}, {99, 99}));
  OccupancyMap newest = visit({0, 0}, {39, 99});
  for (int row = 0; row < 100; ++row) newest.log_odds[{0, row}] = 2.0F;
  ledger.add(newest);
  ledger.add(newest);
  const VisitCoverage coverage = coverage_of(ledger, {day(1.0), day(2.0), day(3.0)});
  Grid<CellTravel> travel(coverage.visits.frame());
  for (int row = 0; row < 100; ++row) travel[{50, row}].passes = 1;
  for (int row = 0; row < 100; ++row) travel[{0, row}].passes = 1;  // under what is a wall now
  const CoverageFigures figures = figures_of(coverage, travel, ledger.map());
  EXPECT_NEAR(figures.free_m2, 9900 * kCellM * kCellM, 1e-9);
  EXPECT_NEAR(figures.free_seen_by_newest_m2, 3900 * kCellM * kCellM, 1e-9);
  EXPECT_NEAR(figures.free_driven_m2, 100 * kCellM * kCellM, 1e-9);
}

}  // namespace
}  // namespace loopstone
