#include "loopstone/registration/correlative_search.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "support/generators.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using Points = std::vector<Eigen::Vector2d>;

/// Sum of the cells that the points fall in.
int sum_at(const Points& source, const Grid<std::uint8_t>& target, const Pose2& target_T_source) {
  int sum = 0;
  for (const auto& point : source)
    sum += target.value_or(target.frame().cell_of(target_T_source * point), kUnknown);
  return sum;
}

double score_of(int sum, std::size_t points) {
  return (static_cast<double>(sum) / static_cast<double>(points) - kUnknown) /
         (kSurface - kUnknown);
}

/// Three loops over the lattice that the header describes.
SearchResult search_exhaustive(const Points& source, const Grid<std::uint8_t>& target,
                               const SearchWindow& window, double min_score,
                               const std::optional<ExcludedPoses>& excluded = {}) {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (const auto& point : source) centre += point;
  centre /= static_cast<double>(source.size());
  const double cell = target.frame().resolution;
  double farthest = cell;
  for (const auto& point : source) farthest = std::max(farthest, (point - centre).norm());
  const double step = cell / farthest;
  const int headings = std::min(static_cast<int>(std::ceil(window.half_yaw_rad / step)),
                                static_cast<int>(std::floor(kPi / step)));
  const int shifts = static_cast<int>(std::ceil(window.half_xy_m / cell));
  SearchResult best;
  int best_sum = 0;
  for (int heading = -headings; heading <= headings; ++heading) {
    for (int row = -shifts; row <= shifts; ++row) {
      for (int column = -shifts; column <= shifts; ++column) {
        // Turned about the points' centre, then moved by whole cells.
        const double yaw = window.centre.yaw + heading * step;
        const Eigen::Vector2d moved = window.centre * centre + cell * Eigen::Vector2d(column, row);
        const Eigen::Vector2d translation = moved - Pose2{0.0, 0.0, yaw}.rotation() * centre;
        const Pose2 pose{translation.x(), translation.y(), wrap_angle(yaw)};
        if (excluded &&
            std::hypot(pose.x - excluded->pose.x, pose.y - excluded->pose.y) < excluded->radius_m &&
            std::abs(wrap_angle(pose.yaw - excluded->pose.yaw)) < excluded->half_yaw_rad) {
          continue;
        }
        const int sum = sum_at(source, target, pose);
        if (score_of(sum, source.size()) < min_score) continue;
        if (best.found && sum <= best_sum) continue;
        best_sum = sum;
        best.found = true;
        best.target_T_source = pose;
        best.score = score_of(sum, source.size());
      }
    }
  }
  return best;
}

Grid<std::uint8_t> random_grid(Rng& rng, bool few_values) {
  Grid<std::uint8_t> grid(GridFrame{.origin = {rng.uniform(-3.0, 0.0), rng.uniform(-3.0, 0.0)},
                                    .resolution = 0.1,
                                    .columns = static_cast<int>(5 + rng.below(50)),
                                    .rows = static_cast<int>(5 + rng.below(50))});
  constexpr std::uint8_t kFew[] = {kContradiction, kUnknown, kUnknown, kSurface};
  for (auto& cell : grid.cells()) {
    cell = few_values ? kFew[rng.below(4)] : static_cast<std::uint8_t>(rng.below(kSurface + 1));
  }
  return grid;
}

/// Pieces of wall: neighbours are alike, as in real grids, so the bounds can prune.
Grid<std::uint8_t> grid_of_strokes(Rng& rng) {
  Grid<std::uint8_t> grid(
      GridFrame{.origin = {-3.0, -3.0}, .resolution = 0.1, .columns = 60, .rows = 60},
      kContradiction);
  for (int stroke = 0; stroke < 8; ++stroke) {
    Eigen::Vector2d at(rng.uniform(5.0, 55.0), rng.uniform(5.0, 55.0));
    const double heading = rng.uniform(-kPi, kPi);
    for (int k = 0; k < 25; ++k, at += Eigen::Vector2d(std::cos(heading), std::sin(heading))) {
      const Cell cell{static_cast<int>(at.x()), static_cast<int>(at.y())};
      if (grid.frame().contains(cell)) grid[cell] = kSurface;
    }
  }
  return grid;
}

void expect_same(const SearchResult& fast, const SearchResult& slow) {
  RC_ASSERT(fast.found == slow.found);
  if (!slow.found) return;
  RC_ASSERT(fast.score == slow.score);
  RC_ASSERT(test::pose_near(fast.target_T_source, slow.target_T_source, 1e-9, 1e-9));
}

RC_GTEST_PROP(BranchAndBoundLaws, IsExactOnRandomGrids, ()) {
  Rng rng(*rc::gen::arbitrary<std::uint64_t>());
  const bool few_values = *rc::gen::arbitrary<bool>();  // many poses with equal scores
  const auto grid =
      *rc::gen::arbitrary<bool>() ? random_grid(rng, few_values) : grid_of_strokes(rng);
  const MaxPyramid pyramid(grid, *rc::gen::inRange(1, 7), kUnknown);
  Points source;
  const int count = *rc::gen::inRange(1, 100);
  for (int i = 0; i < count; ++i)
    source.emplace_back(rng.uniform(-1.5, 1.5), rng.uniform(-1.5, 1.5));
  const SearchWindow window{
      {rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0), rng.uniform(-kPi, kPi)},
      *test::between(0.0, 1.0),
      *test::between(0.0, 0.3)};
  const double min_score = *test::between(-1.0, 0.4);
  const auto slow = search_exhaustive(source, grid, window, min_score);
  expect_same(search_branch_and_bound(source, pyramid, window, min_score), slow);
  RC_CLASSIFY(slow.found);
  if (!slow.found) return;
  // The second best place.
  const ExcludedPoses excluded{slow.target_T_source, *test::between(0.0, 0.8),
                               *test::between(0.0, 0.3)};
  expect_same(search_branch_and_bound(source, pyramid, window, min_score, excluded),
              search_exhaustive(source, grid, window, min_score, excluded));
  // The pose that is returned has the score that is returned.
  RC_ASSERT(std::abs(score_of(sum_at(source, grid, slow.target_T_source), source.size()) -
                     slow.score) < 1e-12);
}

RC_GTEST_PROP(BranchAndBoundLaws, IsExactInWideWindows, ()) {
  // Several levels and more blocks than are read at once; most points fall beside the grid at
  // times.
  Rng rng(*rc::gen::arbitrary<std::uint64_t>());
  const auto grid = *rc::gen::arbitrary<bool>() ? random_grid(rng, true) : grid_of_strokes(rng);
  const MaxPyramid pyramid(grid, *rc::gen::inRange(1, 8), kUnknown);
  Points source;
  const int count = *rc::gen::inRange(1, 12);
  for (int i = 0; i < count; ++i)
    source.emplace_back(rng.uniform(-0.4, 0.4), rng.uniform(-0.4, 0.4));
  const SearchWindow window{
      {rng.uniform(-2.0, 2.0), rng.uniform(-2.0, 2.0), rng.uniform(-kPi, kPi)},
      *test::between(1.0, 5.0),
      *test::between(0.0, 0.5)};
  expect_same(search_branch_and_bound(source, pyramid, window, -1.0),
              search_exhaustive(source, grid, window, -1.0));
}

TEST(BranchAndBound, IsExactWithMorePointsThanOneSumHolds) {
  Rng rng(11);
  const auto grid = grid_of_strokes(rng);
  const MaxPyramid pyramid(grid, 6, kUnknown);
  Points source;
  for (int i = 0; i < 1500; ++i)
    source.emplace_back(rng.uniform(-2.0, 2.0), rng.uniform(-2.0, 2.0));
  const SearchWindow window{{0.1, -0.2, 0.3}, 0.6, 0.1};
  const auto slow = search_exhaustive(source, grid, window, -1.0);
  const auto fast = search_branch_and_bound(source, pyramid, window, -1.0);
  EXPECT_EQ(fast.score, slow.score);
  EXPECT_TRUE(test::pose_near(fast.target_T_source, slow.target_T_source, 1e-9, 1e-9));
}

TEST(BranchAndBound, TiesGoToTheFirstHeadingRowAndColumn) {
  Grid<std::uint8_t> flat(
      GridFrame{.origin = {-5.0, -5.0}, .resolution = 0.1, .columns = 100, .rows = 100}, 150);
  const MaxPyramid pyramid(flat, 5, kUnknown);
  const Points source{{-0.33, 0.01}, {0.41, 0.07}, {0.05, 0.36}};
  const SearchWindow window{{0.02, 0.03, 0.1}, 0.7, 0.5};
  const auto fast = search_branch_and_bound(source, pyramid, window, 0.1);
  const auto slow = search_exhaustive(source, flat, window, 0.1);
  ASSERT_TRUE(fast.found);
  EXPECT_DOUBLE_EQ(fast.score, 0.5);
  EXPECT_TRUE(test::pose_near(fast.target_T_source, slow.target_T_source, 1e-9, 1e-9));
}

TEST(BranchAndBound, AScoreEqualToTheThresholdCounts) {
  Grid<std::uint8_t> grid(
      GridFrame{.origin = {0.0, 0.0}, .resolution = 0.1, .columns = 10, .rows = 10},
      kContradiction);
  grid[{5, 5}] = 150;
  const MaxPyramid pyramid(grid, 4, kContradiction);
  const Points source{{0.05, 0.05}};
  const SearchWindow window{{0.3, 0.3, 0.0}, 0.4, 0.0};
  EXPECT_TRUE(search_branch_and_bound(source, pyramid, window, 0.5).found);
  EXPECT_FALSE(search_branch_and_bound(source, pyramid, window, 0.5001).found);
  const auto found = search_branch_and_bound(source, pyramid, window, 0.5);
  EXPECT_EQ(grid.frame().cell_of(found.target_T_source * source[0]), (Cell{5, 5}));
}

TEST(BranchAndBound, NotFoundMeansThatNoPoseInTheWindowScoresEnough) {
  Rng rng(3);
  for (int trial = 0; trial < 20; ++trial) {
    const auto grid = grid_of_strokes(rng);
    const MaxPyramid pyramid(grid, 6, kUnknown);
    Points source;
    for (int i = 0; i < 30; ++i)
      source.emplace_back(rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0));
    const SearchWindow window{{}, 0.8, 0.4};
    const double best = search_exhaustive(source, grid, window, -1.0).score;
    EXPECT_TRUE(search_branch_and_bound(source, pyramid, window, best - 1e-6).found);
    EXPECT_FALSE(search_branch_and_bound(source, pyramid, window, best + 1e-6).found);
  }
}

TEST(BranchAndBound, FindsATurnedAndShiftedCopyAndPrunes) {
  Rng rng(8);
  Grid<std::uint8_t> grid(
      GridFrame{.origin = {-8.0, -8.0}, .resolution = 0.1, .columns = 160, .rows = 160},
      kContradiction);
  Points source;
  const Pose2 truth{1.3, -0.9, 0.45};
  for (int i = 0; i < 150; ++i) {
    const Eigen::Vector2d point(rng.uniform(-4.0, 4.0), rng.uniform(-4.0, 4.0));
    source.push_back(point);
    const Cell at = grid.frame().cell_of(truth * point);
    for (int row = at.row - 1; row <= at.row + 1; ++row) {
      for (int column = at.column - 1; column <= at.column + 1; ++column)
        grid[{column, row}] = kSurface;
    }
  }
  const SearchWindow window{{0.0, 0.0, 0.0}, 3.0, 0.6};
  const auto found = search_branch_and_bound(source, MaxPyramid(grid, 7, kUnknown), window, 0.2);
  ASSERT_TRUE(found.found);
  EXPECT_TRUE(test::pose_near(found.target_T_source, truth, 0.15, 0.03));
  const double poses = 61.0 * 61.0 * 2.0 * 0.6 / (0.1 / 5.5);
  EXPECT_LT(static_cast<double>(found.evaluations), 0.25 * poses)
      << "no better than trying every pose";
}

TEST(BranchAndBound, NothingToMatchIsNotFound) {
  const MaxPyramid pyramid(Grid<std::uint8_t>(GridFrame{.columns = 3, .rows = 3}, kSurface), 3,
                           kUnknown);
  EXPECT_FALSE(search_branch_and_bound({}, pyramid, {}, -1.0).found);
}

}  // namespace
}  // namespace loopstone
