#include "report/outline.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "report/coverage.hpp"

namespace loopstone {
namespace {

constexpr double kPi = std::numbers::pi;

/// [px^2] on a picture of 100 x 100.
double area(std::span<const Contour> contours) {
  Coverage coverage({0.0, 0.0, 100.0, 100.0});
  coverage.add(contours);
  double sum = 0.0;
  for (const CoveredRun& run : coverage.runs()) sum += run.length * (run.share / 65536.0);
  return sum;
}

double area(const Contour& contour) { return area(std::span(&contour, 1)); }

TEST(Outline, CirclesHaveTheirArea) {
  for (const double radius : {0.3, 1.0, 2.7, 9.0, 40.0}) {
    EXPECT_NEAR(area(circle({50.2, 49.7}, radius)), kPi * radius * radius,
                0.02 + 0.02 * 2.0 * kPi * radius)
        << radius;
  }
  EXPECT_NEAR(area(ring_outline({50.2, 49.7}, 20.0, 3.0)), 2.0 * kPi * 20.0 * 3.0, 4.0);
  EXPECT_NEAR(area(ring_outline({50.2, 49.7}, 1.0, 4.0)), kPi * 9.0, 0.4) << "has no hole";
  EXPECT_EQ(area(ring_outline({50.0, 50.0}, 20.0, 0.0)), 0.0);
}

TEST(Outline, ALineCoversWidthTimesLengthAndTwoHalfDiscs) {
  for (const double width : {0.5, 1.0, 3.0, 12.0}) {
    for (const double angle : {0.0, 0.3, 1.2, kPi / 2.0, 2.5, -2.0}) {
      const Point end{50.0 + 30.0 * std::cos(angle), 50.0 + 30.0 * std::sin(angle)};
      EXPECT_NEAR(area(line_outline(std::vector<Point>{{50.0, 50.0}, end}, width)),
                  30.0 * width + kPi * width * width / 4.0, 0.2 + 0.05 * width)
          << width << " " << angle;
    }
  }
}

TEST(Outline, PointsOnALineDoNotChangeIt) {
  const std::vector<Point> straight{{10.0, 20.0}, {70.0, 50.0}};
  std::vector<Point> dense;
  for (int i = 0; i <= 120; ++i) {
    dense.push_back({10.0 + 0.5 * i, 20.0 + 0.25 * i});
    if (i % 7 == 0) dense.push_back(dense.back());
  }
  EXPECT_NEAR(area(line_outline(dense, 5.0)), area(line_outline(straight, 5.0)), 0.3);
}

// Edges that lie on each other count twice where they cover a pixel in part.
TEST(Outline, ALineThatTurnsBackIsNotMuchWider) {
  const double there = area(line_outline(std::vector<Point>{{10.0, 50.0}, {80.0, 50.5}}, 6.0));
  const std::vector<Point> back{{10.0, 50.0}, {80.0, 50.5}, {40.0, 50.0 + 0.5 * 30.0 / 70.0}};
  EXPECT_NEAR(area(line_outline(back, 6.0)), there, 2.0 * 40.0 * 0.5);
}

TEST(Outline, ABendIsRoundOutsideAndWholeInside) {
  const std::vector<Point> bend{{20.0, 20.0}, {70.0, 20.0}, {70.0, 70.0}};
  // Two pieces that overlap in a square; a quarter of a disc at the corner, a half at each end.
  const double expected = 2.0 * 50.0 * 8.0 - 16.0 + 1.25 * kPi * 16.0;
  EXPECT_NEAR(area(line_outline(bend, 8.0)), expected, 0.5);
  const std::vector<Point> turned(bend.rbegin(), bend.rend());
  EXPECT_NEAR(area(line_outline(turned, 8.0)), area(line_outline(bend, 8.0)), 0.05);
}

TEST(Outline, AnArcOfShortPiecesIsARing) {
  std::vector<Point> arc;
  for (int i = 0; i <= 200; ++i)
    arc.push_back({50.0 + 20.0 * std::cos(kPi * i / 200), 50.0 + 20.0 * std::sin(kPi * i / 200)});
  const double half_ring = kPi * 20.0 * 6.0 + kPi * 9.0;
  EXPECT_NEAR(area(line_outline(arc, 6.0)), half_ring, 0.02 * half_ring);
}

TEST(Outline, TheEdgeOfAPolygonIsClosed) {
  const std::vector<Point> square{{20.0, 20.0}, {60.0, 20.0}, {60.0, 60.0}, {20.0, 60.0}};
  const double expected = 44.0 * 44.0 - (4.0 - kPi) * 4.0 - 36.0 * 36.0;
  EXPECT_NEAR(area(edge_outline(square, 4.0)), expected, 0.5);
  std::vector<Point> repeated = square;
  repeated.push_back(square.front());
  EXPECT_NEAR(area(edge_outline(repeated, 4.0)), expected, 0.5);
  EXPECT_EQ(area(edge_outline(square, 0.0)), 0.0);
}

TEST(Outline, DashesCoverTheirShare) {
  const std::vector<Point> line{{10.0, 30.0}, {50.0, 30.0}, {50.0, 50.0}};  // 60 px
  const double dash = 4.0 * 2.0 + kPi;
  EXPECT_NEAR(area(dashed_outline(line, 2.0, {4.0, 6.0})), 6.0 * dash, 1.0);
  EXPECT_EQ(dashed_outline(line, 2.0, {4.0, 6.0}).size(), 6U);
  EXPECT_NEAR(area(dashed_outline(line, 2.0, {0.01, 5.5})), 11.0 * kPi, 0.7) << "dots";
  EXPECT_NEAR(area(dashed_outline(line, 2.0, {200.0, 6.0})), area(line_outline(line, 2.0)), 0.1);
}

TEST(Outline, WhatIsNoLineIsNothingOrADot) {
  EXPECT_TRUE(line_outline({}, 3.0).empty());
  EXPECT_TRUE(dashed_outline({}, 3.0, {1.0, 1.0}).empty());
  EXPECT_TRUE(line_outline(std::vector<Point>{{5.0, 5.0}}, 3.0).empty());
  EXPECT_TRUE(line_outline(std::vector<Point>{{5.0, 5.0}, {9.0, 5.0}}, 0.0).empty());
  const std::vector<Point> dot{{5.0, 5.0}, {5.0, 5.0}};
  EXPECT_NEAR(area(line_outline(dot, 4.0)), kPi * 4.0, 0.3);
  EXPECT_NEAR(area(edge_outline(dot, 4.0)), kPi * 4.0, 0.3);
  EXPECT_LE(dashed_outline(std::vector<Point>{{0.0, 0.0}, {1e9, 0.0}}, 1.0, {1.0, 1.0}).size(), 1U)
      << "drawn through";
}

}  // namespace
}  // namespace loopstone
