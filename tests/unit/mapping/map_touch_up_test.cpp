#include "loopstone/mapping/map_touch_up.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

const GridFrame kFrame{.origin = {-1.0, -2.0}, .resolution = 0.1, .columns = 50, .rows = 40};

/// Every cell was seen; those of one column in three are occupied.
OccupancyMap striped() {
  OccupancyMap map{Grid<float>(kFrame, -1.0F), Grid<std::uint8_t>(kFrame, 1)};
  for (int row = 0; row < kFrame.rows; ++row)
    for (int column = 0; column < kFrame.columns; column += 3) map.log_odds[{column, row}] = 2.0F;
  return map;
}

Polygon2 crooked() { return {{{0.03, -1.5}, {2.1, -1.1}, {1.4, 0.9}, {0.9, -0.4}}}; }

TEST(MapTouchUp, VisitsTheCellsWhoseCentresLieInside) {
  Rng rng(3);
  for (int round = 0; round < 50; ++round) {
    const Polygon2 polygon =
        Pose2{rng.uniform(-3.0, 4.0), rng.uniform(-3.0, 3.0), rng.uniform(-3.0, 3.0)} * crooked();
    Grid<std::uint8_t> visited(kFrame);
    for_each_cell_in(polygon, kFrame, [&](Cell cell) { ++visited[cell]; });
    for (int row = 0; row < kFrame.rows; ++row) {
      for (int column = 0; column < kFrame.columns; ++column) {
        const Cell cell{column, row};
        EXPECT_EQ(visited[cell], contains(polygon, kFrame.centre_of(cell)) ? 1 : 0);
      }
    }
  }
}

TEST(MapTouchUp, APolygonThinnerThanACellTouchesSome) {
  const Polygon2 line{{{-0.5, -1.02}, {2.0, -1.02}, {2.0, -1.01}, {-0.5, -1.01}}};
  int inside = 0;
  int touched = 0;
  for_each_cell_in(line, kFrame, [&](Cell) { ++inside; });
  for_each_cell_touching(line, kFrame, [&](Cell) { ++touched; });
  EXPECT_EQ(inside, 0);
  EXPECT_GE(touched, 25);
  EXPECT_LE(touched, 27);
}

TEST(MapTouchUp, ErasingFreesWhatWasSeenInsideAndNothingElse) {
  OccupancyMap map = striped();
  map.observed[{21, 20}] = 0;  // a stripe, never seen
  const OccupancyMap before = map;
  std::int64_t expected = 0;
  const std::int64_t erased = erase(map, crooked(), {});
  for (int row = 0; row < kFrame.rows; ++row) {
    for (int column = 0; column < kFrame.columns; ++column) {
      const Cell cell{column, row};
      EXPECT_EQ(map.observed[cell], before.observed[cell]);
      const bool inside = contains(crooked(), kFrame.centre_of(cell));
      if (inside && before.observed[cell] != 0 && before.log_odds[cell] >= 0.0F) {
        ++expected;
        EXPECT_LT(map.log_odds[cell], 0.0F);
      } else {
        EXPECT_EQ(map.log_odds[cell], before.log_odds[cell]);
      }
    }
  }
  EXPECT_EQ(erased, expected);
  EXPECT_GT(erased, 20);
}

TEST(MapTouchUp, CellsAreWhatTheyAreToldWhateverWasSeen) {
  for (const CellSetting setting :
       {CellSetting::kFree, CellSetting::kOccupied, CellSetting::kUnknown}) {
    OccupancyMap map = striped();
    map.observed[{21, 20}] = 0;
    const OccupancyMap before = map;
    Grid<std::uint8_t> inside(kFrame);
    for_each_cell_in(crooked(), kFrame, [&](Cell cell) { inside[cell] = 1; });
    if (setting == CellSetting::kOccupied)
      for_each_cell_touching(crooked(), kFrame, [&](Cell cell) { inside[cell] = 1; });
    const std::int64_t cells = set_cells(map, crooked(), setting, {});
    std::int64_t expected = 0;
    for (std::size_t i = 0; i < inside.cells().size(); ++i) {
      expected += inside.cells()[i];
      const float now = map.log_odds.cells()[i];
      if (inside.cells()[i] == 0) {
        EXPECT_EQ(now, before.log_odds.cells()[i]);
        EXPECT_EQ(map.observed.cells()[i], before.observed.cells()[i]);
      } else {
        EXPECT_EQ(map.observed.cells()[i], setting == CellSetting::kUnknown ? 0 : 1);
        const float sign = setting == CellSetting::kFree       ? -1.0F
                           : setting == CellSetting::kOccupied ? 1.0F
                                                               : 0.0F;
        EXPECT_NEAR(now, sign * 3.476F, 1e-3F);
      }
    }
    EXPECT_EQ(cells, expected);
    EXPECT_GT(cells, 100);
  }
}

TEST(MapTouchUp, CroppingKeepsWhatLiesInAnyOfThePolygons) {
  const OccupancyMap before = striped();
  OccupancyMap map = before;
  const std::vector<Polygon2> kept{crooked(), box_polygon({2.5, 1.0}, {3.0, 1.5})};
  crop(map, kept);
  const GridFrame& frame = map.observed.frame();
  EXPECT_LT(frame.columns, kFrame.columns);
  EXPECT_LT(frame.rows, kFrame.rows);
  int left = 0;
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      const Cell cell{column, row};
      const Eigen::Vector2d centre = frame.centre_of(cell);
      const bool inside = contains(kept[0], centre) || contains(kept[1], centre);
      EXPECT_EQ(map.observed[cell], inside ? 1 : 0);
      // The cells lie where they lay.
      const float was = before.log_odds[kFrame.cell_of(centre)];
      EXPECT_EQ(map.log_odds[cell], inside ? was : 0.0F);
      left += inside ? 1 : 0;
    }
  }
  int expected = 0;
  for (const Polygon2& polygon : kept) for_each_cell_in(polygon, kFrame, [&](Cell) { ++expected; });
  EXPECT_EQ(left, expected);
}

TEST(MapTouchUp, CroppingToANothingLeavesOneUnknownCell) {
  OccupancyMap map = striped();
  crop(map, std::vector{box_polygon({100.0, 100.0}, {101.0, 101.0})});
  EXPECT_EQ(map.observed.cells().size(), 1U);
  EXPECT_EQ(map.observed.cells().front(), 0);
}

}  // namespace
}  // namespace loopstone
