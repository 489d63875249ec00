#include "loopstone/mapping/visit_ledger.hpp"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

constexpr double kCellM = 0.05;

/// What a visit saw: free wherever it looked, but for the occupied cells. Cells are counted from
/// the origin of the map.
OccupancyMap visit(Cell low, Cell high, const std::vector<Cell>& occupied) {
  const GridFrame frame{.origin = {low.column * kCellM, low.row * kCellM},
                        .resolution = kCellM,
                        .columns = high.column - low.column + 1,
                        .rows = high.row - low.row + 1};
  OccupancyMap map{Grid<float>(frame, -2.0F), Grid<std::uint8_t>(frame, 1)};
  for (const Cell cell : occupied)
    map.log_odds[{cell.column - low.column, cell.row - low.row}] = 2.0F;
  return map;
}

std::vector<Cell> wall(int column, int from_row, int to_row) {
  std::vector<Cell> cells;
  for (int row = from_row; row <= to_row; ++row) cells.push_back({column, row});
  return cells;
}

bool is_occupied(const OccupancyMap& map, Cell cell) {
  const Cell corner{static_cast<int>(std::lround(map.log_odds.frame().origin.x() / kCellM)),
                    static_cast<int>(std::lround(map.log_odds.frame().origin.y() / kCellM))};
  return map.probability({cell.column - corner.column, cell.row - corner.row}) > 0.65;
}

constexpr Cell kLow{0, 0};
constexpr Cell kHigh{99, 99};

TEST(VisitLedger, AWallThatWasMovedIsGoneAfterTwoVisitsHoweverOftenItWasSeen) {
  VisitLedger ledger;
  for (int day = 0; day < 500; ++day) ledger.add(visit(kLow, kHigh, wall(20, 10, 60)));
  ledger.add(visit(kLow, kHigh, wall(40, 10, 60)));
  EXPECT_TRUE(is_occupied(ledger.map(), {20, 30}));
  EXPECT_FALSE(is_occupied(ledger.map(), {40, 30}));
  ledger.add(visit(kLow, kHigh, wall(40, 10, 60)));
  EXPECT_FALSE(is_occupied(ledger.map(), {20, 30}));
  EXPECT_TRUE(is_occupied(ledger.map(), {40, 30}));
}

TEST(VisitLedger, WhatOneVisitAloneSaysIsBelievedUntilTheNextOne) {
  VisitLedger ledger;
  ledger.add(visit(kLow, kHigh, wall(20, 10, 60)));
  EXPECT_TRUE(is_occupied(ledger.map(), {20, 30}));
  ledger.add(visit(kLow, kHigh, {}));
  EXPECT_FALSE(is_occupied(ledger.map(), {20, 30}));
}

TEST(VisitLedger, AThingThatStoodThereOnceComesNeverIntoTheMap) {
  VisitLedger ledger;
  for (int day = 0; day < 3; ++day) ledger.add(visit(kLow, kHigh, wall(20, 10, 60)));
  std::vector<Cell> with_box = wall(20, 10, 60);
  with_box.push_back({70, 70});
  ledger.add(visit(kLow, kHigh, with_box));
  EXPECT_FALSE(is_occupied(ledger.map(), {70, 70}));
  ledger.add(visit(kLow, kHigh, wall(20, 10, 60)));
  EXPECT_FALSE(is_occupied(ledger.map(), {70, 70}));
}

TEST(VisitLedger, WhatNobodySawAgainStays) {
  VisitLedger ledger;
  ledger.add(visit(kLow, kHigh, wall(90, 10, 60)));
  for (int day = 0; day < 5; ++day) ledger.add(visit(kLow, {50, 99}, {}));
  EXPECT_TRUE(is_occupied(ledger.map(), {90, 30}));
}

TEST(VisitLedger, VisitsOfDifferentPlacesShareOneGrid) {
  VisitLedger ledger;
  ledger.add(visit({0, 0}, {30, 30}, {{5, 5}}));
  ledger.add(visit({-40, -10}, {10, 50}, {{5, 5}, {-30, 40}}));
  const OccupancyMap map = ledger.map();
  EXPECT_EQ(map.log_odds.frame().columns, 71);
  EXPECT_EQ(map.log_odds.frame().rows, 61);
  EXPECT_TRUE(is_occupied(map, {5, 5}));
  EXPECT_TRUE(is_occupied(map, {-30, 40}));
  // Nobody saw this corner.
  EXPECT_EQ(map.observed[(Cell{70, 0})], 0);
}

TEST(VisitLedger, MapsOfAnotherGridAreRefused) {
  VisitLedger ledger;
  ledger.add(visit(kLow, kHigh, {}));
  OccupancyMap coarse{Grid<float>({.resolution = 0.1, .columns = 4, .rows = 4}),
                      Grid<std::uint8_t>({.resolution = 0.1, .columns = 4, .rows = 4})};
  EXPECT_THROW(ledger.add(coarse), UsageError);
  OccupancyMap between{
      Grid<float>({.origin = {0.02, 0.0}, .resolution = kCellM, .columns = 4, .rows = 4}),
      Grid<std::uint8_t>({.origin = {0.02, 0.0}, .resolution = kCellM, .columns = 4, .rows = 4})};
  EXPECT_THROW(ledger.add(between), UsageError);
}

TEST(VisitLedger, ADoorIsMovableAndTheEdgeOfAWallIsNot) {
  VisitLedger ledger;
  for (int day = 0; day < 10; ++day) {
    // The wall trembles by a cell; the door, far from it, is open on three days of ten.
    std::vector<Cell> seen = wall(day % 2 == 0 ? 20 : 21, 10, 60);
    const std::vector<Cell> always = wall(19, 10, 60);
    seen.insert(seen.end(), always.begin(), always.end());
    if (day % 3 != 0) seen.push_back({60, 30});
    ledger.add(visit(kLow, kHigh, seen));
  }
  const Grid<float> movable = ledger.movable();
  EXPECT_NEAR(static_cast<double>(movable[(Cell{60, 30})]), 7.0 / 12.0, 1e-6);
  EXPECT_EQ(movable[(Cell{21, 30})], 0.0F);
  EXPECT_EQ(movable[(Cell{19, 30})], 0.0F);
  EXPECT_EQ(movable[(Cell{80, 80})], 0.0F);
}

TEST(Changes, TellWhatAppearedAndWhatIsGoneWithItsPlace) {
  std::vector<Cell> before = wall(20, 10, 60);
  std::vector<Cell> now = wall(50, 10, 60);
  const std::vector<Cell> stays = wall(80, 5, 90);
  before.insert(before.end(), stays.begin(), stays.end());
  now.insert(now.end(), stays.begin(), stays.end());
  const auto changes = changes_between(visit(kLow, kHigh, before), visit(kLow, {120, 99}, now));
  ASSERT_EQ(changes.size(), 2U);
  for (const MapChange& change : changes) {
    const int column = change.appeared ? 50 : 20;
    EXPECT_NEAR(change.low.x(), column * kCellM, 1e-9);
    EXPECT_NEAR(change.high.x(), (column + 1) * kCellM, 1e-9);
    EXPECT_NEAR(change.low.y(), 10 * kCellM, 1e-9);
    EXPECT_NEAR(change.high.y(), 61 * kCellM, 1e-9);
    EXPECT_NEAR(change.area_m2, 51 * kCellM * kCellM, 1e-9);
  }
  EXPECT_NE(changes[0].appeared, changes[1].appeared);
}

TEST(Changes, AWallThatTremblesAndWhatWasNotSeenBeforeAreNone) {
  EXPECT_TRUE(
      changes_between(visit(kLow, kHigh, wall(20, 10, 60)), visit(kLow, kHigh, wall(22, 10, 60)))
          .empty());
  // A part that nobody had been to.
  EXPECT_TRUE(
      changes_between(visit(kLow, {40, 99}, {}), visit(kLow, kHigh, wall(70, 10, 60))).empty());
  // Less than noise.
  EXPECT_TRUE(
      changes_between(visit(kLow, kHigh, {}), visit(kLow, kHigh, wall(70, 10, 14))).empty());
}

}  // namespace
}  // namespace loopstone
