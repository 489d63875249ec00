#include "loopstone/grid/ray_walk.hpp"

#include <gtest/gtest.h>

#include <set>
#include <utility>
#include <vector>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

using CellSet = std::set<std::pair<int, int>>;

/// Naive twin of the definition: {floor(p) : p on the segment}. Exact rationals, as scaled whole
/// numbers (short rays: all fits 64 bits): the part of the segment in a half-open column band and
/// that in a half-open row band must share a point.
struct Interval {  // of t * scale in [0, scale]; ends may be open
  std::int64_t low;
  std::int64_t high;
  bool low_open;
  bool high_open;
};

Interval band_crossing(std::int64_t from, std::int64_t delta, std::int64_t cell,
                       std::int64_t scale) {
  // from + t delta in [cell S, (cell + 1) S)
  const std::int64_t near = static_cast<std::int64_t>(cell) * kGridPointsPerCell - from;
  const std::int64_t far = near + kGridPointsPerCell;
  if (delta == 0) {
    if (near <= 0 && 0 < far) return {0, scale, false, false};
    return {1, 0, false, false};
  }
  Interval result{};
  if (delta > 0) {
    result = {near * (scale / delta), far * (scale / delta), false, true};
  } else {
    result = {far * (scale / delta), near * (scale / delta), true, false};
  }
  if (result.low < 0) result.low = 0, result.low_open = false;
  if (result.high > scale) result.high = scale, result.high_open = false;
  return result;
}

bool crosses(GridPoint from, GridPoint to, int column, int row) {
  const std::int64_t dx = std::int64_t{to.x} - from.x;
  const std::int64_t dy = std::int64_t{to.y} - from.y;
  // A multiple of both deltas, so that every t * scale is whole.
  const std::int64_t scale =
      static_cast<std::int64_t>(dx == 0 ? 1 : std::abs(dx)) * (dy == 0 ? 1 : std::abs(dy));
  const Interval x = band_crossing(from.x, dx, column, scale);
  const Interval y = band_crossing(from.y, dy, row, scale);
  const std::int64_t low = std::max(x.low, y.low);
  const std::int64_t high = std::min(x.high, y.high);
  if (low != high) return low < high;
  const bool low_open = (x.low == low && x.low_open) || (y.low == low && y.low_open);
  const bool high_open = (x.high == high && x.high_open) || (y.high == high && y.high_open);
  return !low_open && !high_open;
}

CellSet naive_cells(GridPoint from, GridPoint to) {
  const Cell a = cell_of(from);
  const Cell b = cell_of(to);
  CellSet cells;
  for (int row = std::min(a.row, b.row); row <= std::max(a.row, b.row); ++row) {
    for (int column = std::min(a.column, b.column); column <= std::max(a.column, b.column);
         ++column) {
      if (crosses(from, to, column, row)) cells.insert({column, row});
    }
  }
  return cells;
}

std::vector<Cell> ordered_cells(GridPoint from, GridPoint to) {
  std::vector<Cell> cells;
  walk_ray(from, to, [&](Cell cell) { cells.push_back(cell); });
  return cells;
}

CellSet as_set(const std::vector<Cell>& cells) {
  CellSet set;
  for (const Cell cell : cells) set.insert({cell.column, cell.row});
  return set;
}

CellSet row_cells(GridPoint from, GridPoint to, int first_row, int end_row) {
  CellSet set;
  walk_ray_rows(from, to, first_row, end_row, [&](int row, int first, int last) {
    EXPECT_LE(first, last);
    for (int column = first; column <= last; ++column) {
      EXPECT_TRUE(set.insert({column, row}).second) << "visited twice";
    }
  });
  return set;
}

/// Many ends on cell edges and corners, where ties are.
GridPoint random_point(Rng& rng) {
  const auto coordinate = [&rng] {
    constexpr int kSpan = 14;
    const auto cell = static_cast<std::int32_t>(rng.below(2 * kSpan)) - kSpan;
    const std::int32_t parts[] = {0, 0, 1, 512, 1023, static_cast<std::int32_t>(rng.below(1024))};
    return cell * 1024 + parts[rng.below(6)];
  };
  const std::int32_t x = coordinate();
  return {x, coordinate()};
}

TEST(RayWalk, VisitsExactlyTheCellsOfTheDefinition) {
  Rng rng(1);
  for (int i = 0; i < 20000; ++i) {
    const GridPoint from = random_point(rng);
    const GridPoint to = random_point(rng);
    const auto cells = ordered_cells(from, to);
    const CellSet expected = naive_cells(from, to);
    ASSERT_EQ(as_set(cells), expected) << from.x << ',' << from.y << " -> " << to.x << ',' << to.y;
    ASSERT_EQ(cells.size(), expected.size()) << "a cell was visited twice";
    ASSERT_EQ(cells.front(), cell_of(from));
    ASSERT_EQ(cells.back(), cell_of(to));
  }
}

TEST(RayWalk, StepsAreToNeighboursAndMonotone) {
  Rng rng(2);
  for (int i = 0; i < 5000; ++i) {
    const GridPoint from = random_point(rng);
    const GridPoint to = random_point(rng);
    const auto cells = ordered_cells(from, to);
    for (std::size_t k = 1; k < cells.size(); ++k) {
      const int step_x = cells[k].column - cells[k - 1].column;
      const int step_y = cells[k].row - cells[k - 1].row;
      ASSERT_TRUE(step_x == 0 || (step_x > 0) == (to.x > from.x));
      ASSERT_TRUE(step_y == 0 || (step_y > 0) == (to.y > from.y));
      ASSERT_LE(std::abs(step_x), 1);
      ASSERT_LE(std::abs(step_y), 1);
      ASSERT_GE(std::abs(step_x) + std::abs(step_y), 1);
    }
  }
}

TEST(RayWalk, RowsGiveTheSameCells) {
  Rng rng(3);
  for (int i = 0; i < 20000; ++i) {
    const GridPoint from = random_point(rng);
    const GridPoint to = random_point(rng);
    ASSERT_EQ(row_cells(from, to, -100, 100), as_set(ordered_cells(from, to)))
        << from.x << ',' << from.y << " -> " << to.x << ',' << to.y;
  }
}

TEST(RayWalk, ClippedRowsAreThoseOfTheWholeRay) {
  Rng rng(4);
  for (int i = 0; i < 5000; ++i) {
    const GridPoint from = random_point(rng);
    const GridPoint to = random_point(rng);
    CellSet together;
    const int cut_low = static_cast<int>(rng.below(28)) - 14;
    const int cut_high = cut_low + static_cast<int>(rng.below(5));
    const int edges[] = {-100, cut_low, cut_high, 100};
    for (int band = 0; band < 3; ++band) {
      for (const auto& cell : row_cells(from, to, edges[band], edges[band + 1])) {
        ASSERT_GE(cell.second, edges[band]);
        ASSERT_LT(cell.second, edges[band + 1]);
        together.insert(cell);
      }
    }
    ASSERT_EQ(together, as_set(ordered_cells(from, to)));
  }
}

TEST(RayWalk, IsTheSameFromBothEnds) {
  Rng rng(5);
  for (int i = 0; i < 5000; ++i) {
    const GridPoint from = random_point(rng);
    const GridPoint to = random_point(rng);
    ASSERT_EQ(as_set(ordered_cells(from, to)), as_set(ordered_cells(to, from)));
  }
}

TEST(RayWalk, LongestRaysDoNotOverflow) {
  constexpr std::int32_t kFar = (1 << 30) - 1;
  const GridPoint ends[][2] = {{{-kFar, -kFar}, {kFar, kFar}},
                               {{kFar, -kFar}, {-kFar, kFar}},
                               {{-kFar, 17}, {kFar, -1000}},
                               {{5, -kFar}, {1025, kFar}}};
  for (const auto& [from, to] : ends) {
    std::int64_t count = 0;
    Cell last{};
    walk_ray(from, to, [&](Cell cell) {
      ++count;
      last = cell;
    });
    EXPECT_EQ(last, cell_of(to));
    std::int64_t row_count = 0;
    walk_ray_rows(from, to, -(1 << 20), 1 << 20, [&](int, int first, int end) {
      EXPECT_LE(first, end);
      row_count += end - first + 1;
    });
    EXPECT_EQ(row_count, count);
  }
}

TEST(RayWalk, GridPointLiesInTheCellOfThePoint) {
  Rng rng(6);
  const GridFrame frame{.origin = {-12.35, 7.05}, .resolution = 0.05, .columns = 10, .rows = 10};
  for (int i = 0; i < 20000; ++i) {
    Eigen::Vector2d point(rng.uniform(-100.0, 100.0), rng.uniform(-100.0, 100.0));
    if (i % 2 == 0) point = frame.origin + (point / 0.05).array().round().matrix() * 0.05;  // edges
    ASSERT_EQ(cell_of(grid_point_of(frame, point)), frame.cell_of(point));
  }
}

}  // namespace
}  // namespace loopstone
