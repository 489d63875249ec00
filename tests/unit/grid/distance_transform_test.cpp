#include "loopstone/grid/distance_transform.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

GridFrame frame_of(int columns, int rows, double resolution = 0.05) {
  return {.origin = {1.0, -2.0}, .resolution = resolution, .columns = columns, .rows = rows};
}

Grid<float> naive_distances(const Grid<std::uint8_t>& occupied) {
  const GridFrame& frame = occupied.frame();
  Grid<float> result(frame, std::numeric_limits<float>::infinity());
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      double least = std::numeric_limits<double>::infinity();
      for (int r = 0; r < frame.rows; ++r) {
        for (int c = 0; c < frame.columns; ++c) {
          if (occupied[{c, r}] == 0) continue;
          const double squared = (c - column) * (c - column) + (r - row) * (r - row);
          least = std::min(least, squared);
        }
      }
      result[{column, row}] = static_cast<float>(std::sqrt(least) * frame.resolution);
    }
  }
  return result;
}

TEST(DistanceTransform, EqualsBruteForce) {
  Rng rng(11);
  for (int round = 0; round < 120; ++round) {
    const int columns = 1 + static_cast<int>(rng.below(40));
    const int rows = 1 + static_cast<int>(rng.below(40));
    Grid<std::uint8_t> occupied(frame_of(columns, rows, 0.01 + 0.2 * rng.uniform()));
    const double density = round % 3 == 0 ? 0.003 : 0.3 * rng.uniform();
    for (auto& cell : occupied.cells()) cell = rng.uniform() < density ? 1 : 0;
    ASSERT_EQ(distance_transform(occupied).cells(), naive_distances(occupied).cells())
        << columns << " x " << rows << ", round " << round;
  }
}

TEST(DistanceTransform, WithoutOccupiedCellsIsInfinite) {
  const Grid<std::uint8_t> occupied(frame_of(9, 5));
  const Grid<float> distances = distance_transform(occupied);
  for (const float distance : distances.cells()) EXPECT_TRUE(std::isinf(distance));
  EXPECT_TRUE(distance_transform(Grid<std::uint8_t>{}).empty());
}

TEST(DistanceTransform, SameBytesForAnyNumberOfThreads) {
  Rng rng(12);
  Grid<std::uint8_t> occupied(frame_of(300, 517));
  for (auto& cell : occupied.cells()) cell = rng.uniform() < 0.001 ? 1 : 0;
  const auto one = distance_transform(occupied, Threads{1});
  EXPECT_EQ(one.cells(), distance_transform(occupied, Threads{2}).cells());
  EXPECT_EQ(one.cells(), distance_transform(occupied, Threads{7}).cells());
}

}  // namespace
}  // namespace loopstone
