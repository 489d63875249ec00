#include "loopstone/grid/block_grid.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"
#include "support/generators.hpp"
#include "support/saved_state.hpp"

namespace loopstone {
namespace {

using Written = std::map<std::pair<int, int>, int>;

std::vector<std::pair<Cell, int>> contents(const BlockGrid<int>& grid) {
  std::vector<std::pair<Cell, int>> all;
  grid.for_each([&](Cell cell, int value) {
    if (value != 0) all.push_back({cell, value});
  });
  return all;
}

TEST(BlockGrid, StartsEmpty) {
  const BlockGrid<int> grid(0.1);
  EXPECT_TRUE(grid.empty());
  EXPECT_EQ(grid.find({0, 0}), nullptr);
  EXPECT_EQ(grid.find({-1000000, 1000000}), nullptr);
  EXPECT_TRUE(contents(grid).empty());
}

TEST(BlockGrid, CellsMayBeNegative) {
  const BlockGrid<int> grid(0.1);
  EXPECT_EQ(grid.cell_of(0.05, -0.05), (Cell{0, -1}));
  EXPECT_EQ(grid.cell_of(-0.25, 0.31), (Cell{-3, 3}));
  EXPECT_TRUE(grid.centre_of({-3, 3}).isApprox(Eigen::Vector2d(-0.25, 0.35)));
}

TEST(BlockGrid, CellsAtBothEndsOfTheWorldAreRefused) {
  BlockGrid<int> grid(0.1);
  grid.at({0, 0}) = 1;
  grid.at({1 << 20, 0}) = 2;
  EXPECT_THROW((void)grid.at(grid.cell_of(4e9, 4e9)), UsageError);
  EXPECT_THROW((void)grid.at(grid.cell_of(-1e300, 0.0)), UsageError);
  EXPECT_EQ(contents(grid).size(), 2u) << "nothing changed";
}

RC_GTEST_PROP(BlockGridLaws, IsAMapFromCellsToValues, ()) {
  // Clusters that force the directory to grow in all directions, and far jumps.
  const auto coordinate = rc::gen::oneOf(rc::gen::inRange(-20, 20), rc::gen::inRange(-600, 600));
  const auto writes = *rc::gen::container<std::vector<std::tuple<int, int, int>>>(
      rc::gen::tuple(coordinate, coordinate, rc::gen::inRange(1, 100)));
  BlockGrid<int> grid(0.05);
  Written twin;
  for (const auto& [column, row, value] : writes) {
    RC_ASSERT(grid.at({column, row}) == (twin.contains({column, row}) ? twin[{column, row}] : 0));
    grid.at({column, row}) = value;
    twin[{column, row}] = value;
  }
  for (const auto& [cell, value] : twin) {
    const int* found = grid.find({cell.first, cell.second});
    RC_ASSERT(found != nullptr);
    RC_ASSERT(*found == value);
  }
  for (int k = 0; k < 50; ++k) {
    const std::pair<int, int> cell{*coordinate, *coordinate};
    const int* found = grid.find({cell.first, cell.second});
    const bool untouched = found == nullptr || *found == 0;
    RC_ASSERT(untouched || twin.contains(cell));
  }
  const auto all = contents(grid);
  RC_ASSERT(all.size() == twin.size());
  for (const auto& [cell, value] : all) RC_ASSERT(twin.at({cell.column, cell.row}) == value);
}

RC_GTEST_PROP(BlockGridLaws, OrderOfVisitsDoesNotDependOnTheOrderOfWrites, ()) {
  const auto coordinate = rc::gen::inRange(-300, 300);
  const auto cells =
      *rc::gen::container<std::vector<std::pair<int, int>>>(rc::gen::pair(coordinate, coordinate));
  BlockGrid<int> forwards(1.0);
  BlockGrid<int> backwards(1.0);
  for (auto at = cells.begin(); at != cells.end(); ++at)
    forwards.at({at->first, at->second}) = at->first + 1000;
  for (auto at = cells.rbegin(); at != cells.rend(); ++at)
    backwards.at({at->first, at->second}) = at->first + 1000;
  RC_ASSERT(contents(forwards) == contents(backwards));
}

RC_GTEST_PROP(BlockGridLaws, CentresLieInTheirCell, ()) {
  const BlockGrid<int> grid(*rc::gen::element(0.05, 0.1, 0.2, 0.3, 0.9));
  const Cell cell{*rc::gen::inRange(-5000, 5000), *rc::gen::inRange(-5000, 5000)};
  const Eigen::Vector2d centre = grid.centre_of(cell);
  RC_ASSERT(grid.cell_of(centre.x(), centre.y()) == cell);
}

RC_GTEST_PROP(BlockGridLaws, OneThatWasSavedGoesOnAsIfItHadNotBeen, ()) {
  const auto coordinate = rc::gen::inRange(-200, 200);
  const auto some =
      rc::gen::container<std::vector<std::pair<int, int>>>(rc::gen::pair(coordinate, coordinate));
  const auto before = *some;
  const auto after = *some;
  BlockGrid<float> grid(0.1);
  for (const auto& [column, row] : before)
    grid.at({column, row}) = column % 3 == 0 ? -0.0F : static_cast<float>(row);
  BlockGrid<float> again = test::restored(grid, BlockGrid<float>(0.2));
  RC_ASSERT(again.resolution_m() == grid.resolution_m());
  RC_ASSERT(again.cell_of(0.55, -0.35) == grid.cell_of(0.55, -0.35));
  RC_ASSERT(test::state_of(again) == test::state_of(grid));
  for (const auto& [column, row] : after) {
    grid.at({column, row}) += 1.0F;
    again.at({column, row}) += 1.0F;
  }
  std::vector<std::pair<Cell, float>> cells;
  std::vector<std::pair<Cell, float>> cells_again;
  grid.for_each([&](Cell cell, float value) { cells.emplace_back(cell, value); });
  again.for_each([&](Cell cell, float value) { cells_again.emplace_back(cell, value); });
  RC_ASSERT(cells == cells_again);
  RC_ASSERT(test::state_of(again) == test::state_of(grid));
}

TEST(BlockGrid, AStateThatLeadsOutsideIsRefused) {
  const auto state = [](double resolution, Cell first, int columns, int rows,
                        const std::vector<std::int32_t>& directory, std::uint64_t blocks) {
    return test::state_of(resolution, first, columns, rows, directory, blocks) +
           std::string(blocks < 10 ? blocks * 32 : 0, '\0');
  };
  const auto refused = [](const std::string& bytes) {
    BlockGrid<int> grid(0.1);
    try {
      test::restore(grid, bytes);
    } catch (const DataError&) {
      return true;
    }
    return false;
  };
  EXPECT_FALSE(refused(state(0.1, {0, 0}, 2, 1, {0, -1}, 1)));
  constexpr double kInf = std::numeric_limits<double>::infinity();
  for (const double resolution : {0.0, -0.1, std::nan(""), kInf})
    EXPECT_TRUE(refused(state(resolution, {0, 0}, 2, 1, {0, -1}, 1))) << resolution;
  EXPECT_TRUE(refused(state(0.1, {0, 0}, 2, 1, {1, -1}, 1))) << "no such block";
  EXPECT_TRUE(refused(state(0.1, {0, 0}, 2, 1, {-2, 0}, 1))) << "no such block";
  EXPECT_TRUE(refused(state(0.1, {0, 0}, 3, 1, {0, -1}, 1))) << "size";
  EXPECT_TRUE(refused(state(0.1, {0, 0}, -2, -1, {0, -1}, 1))) << "negative";
  EXPECT_TRUE(refused(state(0.1, {1 << 30, 0}, 2, 1, {0, -1}, 1))) << "far away";
  EXPECT_TRUE(refused(state(0.1, {0, 0}, 2, 1, {0, -1}, std::uint64_t{1} << 50))) << "blocks";
}

}  // namespace
}  // namespace loopstone
