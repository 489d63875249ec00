#include "loopstone/report/landmark_drawing.hpp"

#include <gtest/gtest.h>

namespace loopstone {
namespace {

TEST(LandmarkDrawing, LandmarksAreOccupiedAndTheRestIsFree) {
  const std::vector<MappedLandmark> landmarks{{1, {2.0, 3.0}}, {2, {-4.0, 1.0}, 0.0, 0.5}};
  const Grid<std::int8_t> grid = drawn_landmarks(landmarks, 2.0);
  const GridFrame& frame = grid.frame();
  EXPECT_EQ(grid[frame.cell_of({2.0, 3.0})], 100);
  EXPECT_EQ(grid[frame.cell_of({-4.0, 1.45})], 100);
  EXPECT_EQ(grid[frame.cell_of({2.0, 3.3})], 0);
  EXPECT_TRUE(frame.contains(frame.cell_of({3.9, 4.9})));
  EXPECT_TRUE(frame.contains(frame.cell_of({-5.9, -0.9})));
  EXPECT_EQ(frame.resolution, 0.05);
}

TEST(LandmarkDrawing, LargePlacesHaveLargerCells) {
  const std::vector<MappedLandmark> landmarks{{1, {0.0, 0.0}}, {2, {5000.0, 3000.0}}};
  const Grid<std::int8_t> grid = drawn_landmarks(landmarks);
  EXPECT_LT(grid.frame().cell_count(), 4'100'000U);
  EXPECT_EQ(grid[grid.frame().cell_of({5000.0, 3000.0})], 100);
}

}  // namespace
}  // namespace loopstone
