#include "loopstone/grid/tile_grid.hpp"

#include <gtest/gtest.h>

#include <map>
#include <utility>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

TEST(TileGrid, HoldsWhatAMapHolds) {
  Rng rng(2);
  TileGrid<int> grid(0.05);
  std::map<std::pair<int, int>, int> twin;
  for (int i = 0; i < 5000; ++i) {
    const Cell cell{static_cast<int>(rng.uniform(-300.0, 300.0)),
                    static_cast<int>(rng.uniform(-300.0, 300.0))};
    grid.at(cell) = i + 1;
    twin[{cell.column, cell.row}] = i + 1;
  }
  for (int row = -310; row < 310; ++row) {
    for (int column = -310; column < 310; ++column) {
      const auto known = twin.find({column, row});
      const int* found = grid.find({column, row});
      EXPECT_EQ(found == nullptr ? 0 : *found, known == twin.end() ? 0 : known->second);
    }
  }
}

TEST(TileGrid, TilesAreListedByRowThenColumn) {
  TileGrid<int> grid;
  EXPECT_TRUE(grid.empty());
  for (const Cell cell : {Cell{100, -1}, Cell{-1, 100}, Cell{-100, -1}, Cell{0, 0}}) {
    grid.at(cell) = 1;
  }
  const std::vector<Cell> tiles = grid.tiles();
  const std::vector<Cell> expected{{-2, -1}, {1, -1}, {0, 0}, {-1, 1}};
  EXPECT_EQ(tiles, expected);
  EXPECT_EQ(grid.memory_bytes(), 4U * 64 * 64 * sizeof(int));
  grid.erase_tile({0, 0});
  EXPECT_EQ(grid.find({0, 0}), nullptr);
  EXPECT_EQ(grid.find_tile({5, 5}), nullptr);
}

TEST(TileGrid, TilesStayWhereTheyAre) {
  TileGrid<int> grid;
  int* first = &grid.at({3, 4});
  *first = 7;
  for (int i = 0; i < 20000; i += 64) grid.at({i, i}) = 1;
  EXPECT_EQ(first, &grid.at({3, 4}));
  EXPECT_EQ(*first, 7);
}

}  // namespace
}  // namespace loopstone
