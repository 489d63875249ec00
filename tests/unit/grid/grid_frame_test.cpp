#include "loopstone/grid/grid_frame.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "loopstone/base/error.hpp"
#include "loopstone/grid/grid.hpp"
#include "support/generators.hpp"

namespace loopstone {
namespace {

TEST(GridFrame, ColumnsGrowWithXAndRowsWithY) {
  const GridFrame frame{.origin = {-1.0, 2.0}, .resolution = 0.5, .columns = 4, .rows = 3};
  EXPECT_EQ(frame.cell_of({-1.0, 2.0}), (Cell{0, 0}));
  EXPECT_EQ(frame.cell_of({-0.49, 2.0}), (Cell{1, 0}));
  EXPECT_EQ(frame.cell_of({-0.99, 3.49}), (Cell{0, 2}));
  EXPECT_EQ(frame.cell_of({-1.01, 1.99}), (Cell{-1, -1})) << "rounded to zero instead of down";
  EXPECT_TRUE(frame.centre_of({1, 2}).isApprox(Eigen::Vector2d(-0.25, 3.25)));
  EXPECT_TRUE(frame.contains({3, 2}));
  EXPECT_FALSE(frame.contains({4, 2}));
  EXPECT_FALSE(frame.contains({3, 3}));
  EXPECT_FALSE(frame.contains({-1, 0}));
  EXPECT_FALSE(frame.contains({0, -1}));
}

TEST(GridFrame, IndexCountsEachCellOnce) {
  const GridFrame frame{.columns = 7, .rows = 5};
  std::set<std::size_t> seen;
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column)
      seen.insert(frame.index_of({column, row}));
  }
  EXPECT_EQ(seen.size(), frame.cell_count());
  EXPECT_EQ(*seen.rbegin(), frame.cell_count() - 1);
  EXPECT_EQ(frame.index_of({1, 0}), 1U) << "row-major";
}

TEST(Grid, ReadsOutsideAsTold) {
  Grid<int> grid(GridFrame{.columns = 2, .rows = 2}, 5);
  grid[{1, 0}] = 7;
  EXPECT_EQ(grid.value_or({1, 0}, -1), 7);
  EXPECT_EQ(grid.value_or({0, 1}, -1), 5);
  EXPECT_EQ(grid.value_or({2, 0}, -1), -1);
  EXPECT_EQ(grid.value_or({0, -1}, -1), -1);
  EXPECT_TRUE(Grid<int>{}.empty());
  EXPECT_EQ(Grid<int>{}.value_or({0, 0}, 3), 3);
}

TEST(GridFrame, NumbersThatDoNotFitBecomeTheNearestThatDo) {
  constexpr int kMost = std::numeric_limits<int>::max();
  EXPECT_EQ(floor_to_int(-0.5), -1);
  EXPECT_EQ(floor_to_int(2147483646.5), kMost - 1);
  EXPECT_EQ(floor_to_int(1e300), kMost);
  EXPECT_EQ(floor_to_int(-1e300), -kMost);
  EXPECT_EQ(floor_to_int(std::numeric_limits<double>::infinity()), kMost);
  EXPECT_EQ(floor_to_int(std::nan("")), -kMost);
  const GridFrame frame{.origin = {0.0, 0.0}, .resolution = 0.05, .columns = 4, .rows = 3};
  EXPECT_FALSE(frame.contains(frame.cell_of({1e12, 0.1})));
  EXPECT_FALSE(frame.contains(frame.cell_of({std::nan(""), 0.1})));
}

TEST(GridFrame, GridsThatNoMemoryHoldsAreRefused) {
  const auto error = [](const Eigen::Vector2d& low, const Eigen::Vector2d& high) -> std::string {
    try {
      (void)frame_covering(low, high, 0.05, 0.1);
    } catch (const UsageError& refused) {
      return refused.what();
    }
    return "";
  };
  EXPECT_EQ(error({0.0, 0.0}, {1000.0, 1000.0}), "");
  EXPECT_NE(error({0.0, 0.0}, {4e9, 1.0}).find("4e+09 m x 1.25 m"), std::string::npos);
  EXPECT_NE(error({0.0, 0.0}, {1e5, 1e5}), "");
  EXPECT_NE(error({0.0, 0.0}, {1e300, 1e300}), "");
  EXPECT_LT(error({-1e308, 0.0}, {1e308, 1e308}).size(), 200u);
  EXPECT_NE(error({0.0, 0.0}, {std::nan(""), 1.0}), "");
}

RC_GTEST_PROP(GridFrameLaws, CentresAndInnerPointsLieInTheirCell, ()) {
  const GridFrame frame{.origin = {*test::between(-50.0, 50.0), *test::between(-50.0, 50.0)},
                        .resolution = *rc::gen::element(0.02, 0.05, 0.1, 0.3, 1.0),
                        .columns = 10,
                        .rows = 10};
  const Cell cell{*rc::gen::inRange(-2000, 2000), *rc::gen::inRange(-2000, 2000)};
  RC_ASSERT(frame.cell_of(frame.centre_of(cell)) == cell);
  const Eigen::Vector2d off(*test::between(-0.499, 0.499), *test::between(-0.499, 0.499));
  RC_ASSERT(frame.cell_of(frame.centre_of(cell) + off * frame.resolution) == cell);
}

RC_GTEST_PROP(GridFrameLaws, CoveringIsEnoughAndNoMore, ()) {
  const double resolution = *rc::gen::element(0.05, 0.1, 0.25);
  const double margin = *test::between(0.0, 1.0);
  const Eigen::Vector2d low(*test::between(-20.0, 20.0), *test::between(-20.0, 20.0));
  const Eigen::Vector2d high =
      low + Eigen::Vector2d(*test::between(0.0, 10.0), *test::between(0.0, 10.0));
  const GridFrame frame = frame_covering(low, high, resolution, margin);
  const Eigen::Vector2d wide(margin, margin);
  const Eigen::Vector2d top =
      frame.origin + resolution * Eigen::Vector2d(frame.columns, frame.rows);
  constexpr double kRounding = 1e-9;
  for (int axis = 0; axis < 2; ++axis) {
    RC_ASSERT(frame.origin(axis) <= low(axis) - margin + kRounding);
    RC_ASSERT(frame.origin(axis) > low(axis) - margin - resolution - kRounding);
    RC_ASSERT(top(axis) >= high(axis) + margin - kRounding);
    RC_ASSERT(top(axis) <= high(axis) + margin + resolution + kRounding);
    const double cells = frame.origin(axis) / resolution;
    RC_ASSERT(std::abs(cells - std::round(cells)) < 1e-6);
  }
}

}  // namespace
}  // namespace loopstone
