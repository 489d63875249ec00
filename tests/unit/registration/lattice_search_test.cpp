#include "registration/lattice_search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/grid/max_pyramid.hpp"
#include "registration/tile_reader.hpp"

namespace loopstone {
namespace {

constexpr int kColumns = 37;
constexpr int kRows = 29;

Grid<std::uint8_t> random_grid(Rng& rng, double share_of_surface) {
  Grid<std::uint8_t> grid(
      GridFrame{.origin = {-1.8, -1.4}, .resolution = 0.1, .columns = kColumns, .rows = kRows},
      kContradiction);
  for (auto& cell : grid.cells()) {
    if (rng.uniform(0.0, 1.0) < share_of_surface)
      cell = static_cast<std::uint8_t>(1 + rng.below(kSurface));
  }
  return grid;
}

/// Cells on the grid and around it, as the area keeps them, with where they really are.
struct AreaCells {
  CellList kept{};
  std::vector<std::pair<int, int>> real{};
};

AreaCells random_cells(Rng& rng, const CellArea& area, std::size_t count) {
  AreaCells cells;
  for (std::size_t i = 0; i < count; ++i) {
    const int column = static_cast<int>(rng.below(120)) - 40;
    const int row = static_cast<int>(rng.below(120)) - 40;
    cells.real.emplace_back(column, row);
    cells.kept.columns.push_back(std::clamp(column - area.first_column, 0, area.columns - 1));
    cells.kept.rows.push_back(std::clamp(row - area.first_row, 0, area.rows - 1));
  }
  return cells;
}

/// The largest value in a square of cells.
int largest(const Grid<std::uint8_t>& grid, int column, int row, int side) {
  int most = 0;
  for (int r = row; r < row + side; ++r) {
    for (int c = column; c < column + side; ++c)
      most = std::max<int>(most, grid.value_or({c, r}, kUnknown));
  }
  return most;
}

/// What the reader should add for blocks that begin at a shift, `margin` cells wider on every side.
TileSums sums_by_hand(const Grid<std::uint8_t>& grid, const AreaCells& cells, int level, int column,
                      int row, int margin) {
  const int side = 1 << level;
  TileSums sums{};
  for (const auto& [c, r] : cells.real) {
    for (int line = 0; line < kTileSide; ++line) {
      for (int lane = 0; lane < kTileSide; ++lane) {
        sums[static_cast<std::size_t>(line * kTileSide + lane)] +=
            largest(grid, c + column + lane * side - margin, r + row + line * side - margin,
                    side + 2 * margin);
      }
    }
  }
  return sums;
}

TEST(TileReader, SumsSixteenBlocksBeforeAndAfterTheLevelIsLaidOutAnew) {
  Rng rng(5);
  const auto grid = random_grid(rng, 0.3);
  const MaxPyramid pyramid(grid, 5, kUnknown);
  constexpr int kHalf = 20;
  for (const int level : {0, 2, 4}) {
    const CellArea area = cell_area(grid.frame(), kHalf, 1 << 4);
    TileReader reader(pyramid.level(level), area);
    const AreaCells cells = random_cells(rng, area, 300);
    // Enough to read more points than there are tiles.
    for (int trial = 0; trial < 60; ++trial) {
      const int column = static_cast<int>(rng.below(2 * kHalf + 1)) - kHalf;
      const int row = static_cast<int>(rng.below(2 * kHalf + 1)) - kHalf;
      TileSums sums{};
      reader.add(cells.kept, 0, 300, column + kHalf, row + kHalf, sums);
      ASSERT_EQ(sums, sums_by_hand(grid, cells, level, column, row, 0))
          << "level " << level << ", trial " << trial;
    }
  }
}

TEST(TileReader, WidenedBlocksReachFartherOnEverySide) {
  Rng rng(6);
  const auto grid = random_grid(rng, 0.02);
  const MaxPyramid pyramid(grid, 5, kUnknown);
  constexpr int kHalf = 24;
  constexpr int kMargin = 4;
  const CellArea area = cell_area(grid.frame(), kHalf, 1 << 4);
  const TileReader reader(pyramid.level(4), area);
  const AreaCells cells = random_cells(rng, area, 300);
  for (int trial = 0; trial < 20; ++trial) {
    const int column = static_cast<int>(rng.below(2 * (kHalf - kMargin) + 1)) - kHalf + kMargin;
    const int row = static_cast<int>(rng.below(2 * (kHalf - kMargin) + 1)) - kHalf + kMargin;
    TileSums sums{};
    reader.add_widened(cells.kept, 0, 300, column + kHalf, row + kHalf, kMargin, sums);
    ASSERT_EQ(sums, sums_by_hand(grid, cells, 4, column, row, kMargin)) << "trial " << trial;
  }
}

void expect_same(const SearchResult& again, const SearchResult& fresh) {
  EXPECT_EQ(again.found, fresh.found);
  EXPECT_EQ(again.score, fresh.score);
  EXPECT_EQ(again.target_T_source.x, fresh.target_T_source.x);
  EXPECT_EQ(again.target_T_source.y, fresh.target_T_source.y);
  EXPECT_EQ(again.target_T_source.yaw, fresh.target_T_source.yaw);
}

TEST(LatticeSearch, AnswersALaterQuestionAsAFreshSearchWould) {
  Rng rng(7);
  for (int trial = 0; trial < 20; ++trial) {
    const auto grid = random_grid(rng, 0.2);
    const MaxPyramid pyramid(grid, 7, kUnknown);
    std::vector<Eigen::Vector2d> source;
    for (int i = 0; i < 60; ++i)
      source.emplace_back(rng.uniform(-1.5, 1.5), rng.uniform(-1.5, 1.5));
    const SearchWindow window{{0.1, -0.2, 0.3}, trial % 2 == 0 ? 1.0 : 4.0, 0.4};
    LatticeSearch search(source, pyramid, window);
    const SearchResult best = search.best(-0.5);
    ASSERT_TRUE(best.found);
    expect_same(best, search_branch_and_bound(source, pyramid, window, -0.5));
    const ExcludedPoses around{best.target_T_source, 0.4, 0.2};
    // Stricter than before, then less so than ever.
    for (const double min_score : {best.score - 0.05, -0.5, -1.0}) {
      expect_same(search.best(min_score, around),
                  search_branch_and_bound(source, pyramid, window, min_score, around));
    }
    expect_same(search.best(-0.5), best);
  }
}

}  // namespace
}  // namespace loopstone
