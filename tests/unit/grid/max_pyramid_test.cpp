#include "loopstone/grid/max_pyramid.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

Grid<std::uint8_t> random_grid(int columns, int rows, std::uint64_t seed) {
  Grid<std::uint8_t> grid(
      GridFrame{.origin = {-1.0, 2.0}, .resolution = 0.1, .columns = columns, .rows = rows});
  Rng rng(seed);
  for (auto& cell : grid.cells()) cell = static_cast<std::uint8_t>(rng.below(256));
  return grid;
}

std::uint8_t brute_force_maximum(const Grid<std::uint8_t>& grid, int level, int column, int row,
                                 std::uint8_t outside) {
  std::uint8_t maximum = 0;
  for (int r = row; r < row + (1 << level); ++r) {
    for (int c = column; c < column + (1 << level); ++c)
      maximum = std::max(maximum, grid.value_or({c, r}, outside));
  }
  return maximum;
}

RC_GTEST_PROP(MaxPyramidLaws, EveryBoundIsTheMaximumOfItsWindow, ()) {
  const int columns = *rc::gen::inRange(1, 24);
  const int rows = *rc::gen::inRange(1, 24);
  const int levels = *rc::gen::inRange(1, 6);
  const auto outside = static_cast<std::uint8_t>(*rc::gen::element(0, 100, 255));
  const auto grid = random_grid(columns, rows, *rc::gen::arbitrary<std::uint64_t>());
  const MaxPyramid pyramid(grid, levels, outside);
  RC_ASSERT(pyramid.level_count() == levels);
  RC_ASSERT(pyramid.frame() == grid.frame());
  const int level = *rc::gen::inRange(0, levels);
  // Windows that start outside reach into the grid, end beyond it, or miss it.
  for (int row = -(1 << levels) - 2; row < rows + 3; ++row) {
    for (int column = -(1 << levels) - 2; column < columns + 3; ++column) {
      RC_ASSERT(pyramid.bound(level, column, row) ==
                brute_force_maximum(grid, level, column, row, outside));
    }
  }
}

TEST(MaxPyramid, FarWindowsAreOutside) {
  const MaxPyramid pyramid(random_grid(10, 10, 1), 3, 42);
  for (const int far : {-1'000'000, 1'000'000}) {
    EXPECT_EQ(pyramid.bound(2, far, 0), 42);
    EXPECT_EQ(pyramid.bound(2, 0, far), 42);
  }
}

}  // namespace
}  // namespace loopstone
