#include "loopstone/evaluation/map_score.hpp"

#include <gtest/gtest.h>

namespace loopstone {
namespace {

/// A room of 10 x 6 m with walls of one cell, free inside, unknown outside.
Grid<CellState> room(double resolution, const Eigen::Vector2d& corner = {0.0, 0.0},
                     int margin_cells = 4) {
  const int columns = static_cast<int>(10.0 / resolution + 0.5);
  const int rows = static_cast<int>(6.0 / resolution + 0.5);
  GridFrame frame;
  frame.resolution = resolution;
  frame.origin = corner - Eigen::Vector2d::Constant(margin_cells * resolution);
  frame.columns = columns + 2 * margin_cells;
  frame.rows = rows + 2 * margin_cells;
  Grid<CellState> map(frame, CellState::kUnknown);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const bool wall = row == 0 || column == 0 || row == rows - 1 || column == columns - 1;
      map[{column + margin_cells, row + margin_cells}] =
          wall ? CellState::kOccupied : CellState::kFree;
    }
  }
  return map;
}

TEST(ClassifyCells, FollowsTheThresholdsOfMapServer) {
  GridFrame frame;
  frame.columns = 6;
  frame.rows = 1;
  Grid<std::int8_t> percent(frame);
  percent.cells() = {-1, 0, 20, 50, 65, 100};
  const std::vector<CellState> expected{CellState::kUnknown,  CellState::kFree,
                                        CellState::kFree,     CellState::kUnknown,
                                        CellState::kOccupied, CellState::kOccupied};
  EXPECT_EQ(classify_cells(percent).cells(), expected);
}

TEST(MapScore, OfTheTruthItselfIsPerfect) {
  const Grid<CellState> truth = room(0.1);
  const MapScore score = score_map(truth, truth);
  EXPECT_EQ(score.precision, 1.0);
  EXPECT_EQ(score.recall, 1.0);
  EXPECT_EQ(score.f1, 1.0);
  EXPECT_EQ(score.free_iou, 1.0);
  EXPECT_EQ(score.mean_distance_m, 0.0);
  EXPECT_EQ(score.mean_gap_m, 0.0);
  EXPECT_EQ(score.occupied_cells, 2 * 100 + 2 * 58);
}

TEST(MapScore, FollowsTheFrameOfTheMap) {
  const Grid<CellState> truth = room(0.1);
  const Grid<CellState> shifted = room(0.1, {100.0, -50.0}, 9);
  EXPECT_EQ(score_map(shifted, truth).f1, 0.0);
  const MapScore score = score_map(shifted, truth, Pose2{-100.0, 50.0, 0.0});
  EXPECT_NEAR(score.f1, 1.0, 1e-12);
  EXPECT_NEAR(score.free_iou, 1.0, 1e-3);
}

TEST(MapScore, AWallBeyondTheToleranceIsWrong) {
  const Grid<CellState> truth = room(0.1);
  const MapScore near = score_map(room(0.1, {0.1, 0.0}), truth, {}, 0.1);
  EXPECT_NEAR(near.precision, 1.0, 1e-12) << "one cell away, the tolerance is one cell";
  const MapScore far = score_map(room(0.1, {0.3, 0.0}), truth, {}, 0.1);
  EXPECT_LT(far.precision, 0.8);
  EXPECT_GT(far.precision, 0.5) << "the long walls still lie on themselves";
  EXPECT_GT(far.mean_distance_m, 0.05);
  EXPECT_LT(far.free_iou, 0.96);
}

TEST(MapScore, MissingWallsCostRecallAndInventedOnesPrecision) {
  const Grid<CellState> truth = room(0.1);
  Grid<CellState> half = truth;
  for (int row = 0; row < half.frame().rows; ++row) {
    for (int column = 0; column < half.frame().columns / 2; ++column) {
      half[{column, row}] = CellState::kUnknown;
    }
  }
  const MapScore missing = score_map(half, truth);
  EXPECT_EQ(missing.precision, 1.0);
  EXPECT_NEAR(missing.recall, 0.5, 0.01);
  EXPECT_NEAR(missing.free_iou, 0.5, 0.01);
  const MapScore invented = score_map(truth, half);
  EXPECT_NEAR(invented.precision, 0.5, 0.01);
  EXPECT_EQ(invented.recall, 1.0);
}

TEST(MapScore, TheInsideOfAThickWallNeedNotBeFound) {
  Grid<CellState> truth = room(0.1);
  for (int row = 0; row < truth.frame().rows; ++row) {
    for (int column = 60; column < truth.frame().columns; ++column) {
      truth[{column, row}] = CellState::kOccupied;
    }
  }
  Grid<CellState> seen = room(0.1);
  for (int row = 0; row < seen.frame().rows; ++row) {
    for (int column = 60; column < seen.frame().columns; ++column) {
      seen[{column, row}] = column == 60 ? truth[{column, row}] : CellState::kUnknown;
    }
  }
  EXPECT_EQ(score_map(seen, truth).recall, 1.0);
}

TEST(MapScore, ResolutionsMayDiffer) {
  const MapScore score = score_map(room(0.05), room(0.1));
  EXPECT_EQ(score.precision, 1.0);
  EXPECT_EQ(score.recall, 1.0);
  EXPECT_GT(score.free_iou, 0.95);
}

TEST(MapScore, OfAnEmptyMapIsZeroNotInfinite) {
  const Grid<CellState> truth = room(0.1);
  const Grid<CellState> empty(truth.frame(), CellState::kUnknown);
  for (const MapScore& score : {score_map(empty, truth), score_map(Grid<CellState>{}, truth)}) {
    EXPECT_EQ(score.precision, 0.0);
    EXPECT_EQ(score.recall, 0.0);
    EXPECT_EQ(score.f1, 0.0);
    EXPECT_EQ(score.free_iou, 0.0);
    EXPECT_EQ(score.mean_gap_m, 1.0);
  }
}

}  // namespace
}  // namespace loopstone
