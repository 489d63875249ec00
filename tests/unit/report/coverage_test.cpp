#include "report/coverage.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace loopstone {
namespace {

constexpr PixelBox kBox{0.0, 0.0, 40.0, 30.0};

/// [px^2]
double area(std::span<const CoveredRun> runs) {
  double sum = 0.0;
  for (const CoveredRun& run : runs) sum += run.length * (run.share / 65536.0);
  return sum;
}

double area(const Contour& contour, const PixelBox& box = kBox) {
  Coverage coverage(box);
  coverage.add(contour);
  return area(coverage.runs());
}

double area_by_corners(const Contour& contour) {
  double twice = 0.0;
  for (std::size_t i = 0; i < contour.size(); ++i) {
    const Point& a = contour[i];
    const Point& b = contour[(i + 1) % contour.size()];
    twice += a.x * b.y - a.y * b.x;
  }
  return 0.5 * std::abs(twice);
}

/// A polygon that does not cross itself.
Contour random_star(std::mt19937& random) {
  std::uniform_real_distribution<double> radius(1.0, 12.0);
  const int corners = std::uniform_int_distribution<int>(3, 12)(random);
  Contour star;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / corners;
    const double r = radius(random);
    star.push_back({20.0 + r * std::cos(angle), 15.0 + r * std::sin(angle)});
  }
  return star;
}

/// How many times the contour goes round a point.
int winding(const Contour& contour, Point at) {
  int turns = 0;
  for (std::size_t i = 0; i < contour.size(); ++i) {
    const Point& a = contour[i];
    const Point& b = contour[(i + 1) % contour.size()];
    if ((a.y <= at.y) == (b.y <= at.y)) continue;
    const double x = a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x);
    if (x < at.x) turns += a.y < b.y ? 1 : -1;
  }
  return turns;
}

TEST(Coverage, SumsToTheAreaOfAPolygon) {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const Contour star = random_star(random);
    EXPECT_NEAR(area(star), area_by_corners(star), 0.1) << i;
    const Contour turned(star.rbegin(), star.rend());
    EXPECT_NEAR(area(turned), area(star), 0.01) << i;
  }
}

/// The share of a pixel's samples that a contour goes round.
double sampled_share(const Contour& contour, int row, int column) {
  constexpr int kSide = 32;
  int inside = 0;
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const Point at{column + (j + 0.5) / kSide, row + (i + 0.5) / kSide};
      inside += winding(contour, at) != 0 ? 1 : 0;
    }
  }
  return inside / double{kSide * kSide};
}

TEST(Coverage, EachPixelIsCoveredAsItsSamplesSay) {
  std::mt19937 random(2);
  for (int i = 0; i < 10; ++i) {
    const Contour star = random_star(random);
    Coverage coverage(kBox);
    coverage.add(star);
    std::array<std::array<double, 40>, 30> shares{};
    for (const CoveredRun& run : coverage.runs()) {
      for (int column = run.column; column < run.column + run.length; ++column)
        shares.at(static_cast<std::size_t>(run.row)).at(static_cast<std::size_t>(column)) +=
            run.share / 65536.0;
    }
    for (int row = 0; row < 30; ++row) {
      for (int column = 0; column < 40; ++column) {
        EXPECT_NEAR(shares[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)],
                    sampled_share(star, row, column), 0.05)
            << i << ": " << row << ", " << column;
      }
    }
  }
}

TEST(Coverage, BoxesBesideEachOtherShareAShape) {
  std::mt19937 random(3);
  for (int i = 0; i < 100; ++i) {
    const Contour star = random_star(random);
    const double x = std::uniform_real_distribution<double>(8.0, 32.0)(random);
    const double y = std::uniform_real_distribution<double>(5.0, 25.0)(random);
    const double parts = area(star, {0.0, 0.0, x, y}) + area(star, {x, 0.0, 40.0, y}) +
                         area(star, {0.0, y, x, 30.0}) + area(star, {x, y, 40.0, 30.0});
    EXPECT_NEAR(parts, area(star), 0.2) << i;
  }
}

TEST(Coverage, AShapeAroundTheBoxFillsItToItsBrokenEdges) {
  const Contour around{{-5e6, -7e5}, {9e7, -8e3}, {1e8, 1e9}, {-3e7, 5e6}};
  EXPECT_DOUBLE_EQ(area(around), 1200.0);
  EXPECT_DOUBLE_EQ(area(around, {2.25, 1.5, 10.5, 8.75}), 8.25 * 7.25);
  Coverage coverage(kBox);
  coverage.add(around);
  EXPECT_EQ(coverage.runs().size(), 60U);  // a pixel and the rest, for each row
}

TEST(Coverage, WhatIsCoveredTwiceCountsOnce) {
  const Contour low{{2.0, 2.0}, {12.0, 2.0}, {12.0, 12.0}, {2.0, 12.0}};
  const Contour high{{7.0, 7.0}, {17.0, 7.0}, {17.0, 17.0}, {7.0, 17.0}};
  Coverage coverage(kBox);
  coverage.add(std::vector{low, high});
  EXPECT_DOUBLE_EQ(area(coverage.runs()), 175.0);
  EXPECT_TRUE(coverage.runs().empty()) << "the shapes were taken";
}

TEST(Coverage, AHoleGoesRoundTheOtherWay) {
  const Contour edge{{2.0, 2.0}, {12.0, 2.0}, {12.0, 12.0}, {2.0, 12.0}};
  const Contour hole{{4.0, 4.0}, {4.0, 8.5}, {8.5, 8.5}, {8.5, 4.0}};
  Coverage coverage(kBox);
  coverage.add(std::vector{edge, hole});
  EXPECT_DOUBLE_EQ(area(coverage.runs()), 100.0 - 4.5 * 4.5);
}

TEST(Coverage, WhatIsOutsideOrNoShapeCoversNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const Contour& contour : std::vector<Contour>{
           {},
           {{5.0, 5.0}},
           {{5.0, 5.0}, {9.0, 9.0}},
           {{-9.0, 2.0}, {-1.0, 2.0}, {-5.0, 20.0}},
           {{40.0, 2.0}, {50.0, 2.0}, {45.0, 20.0}},
           {{5.0, -9.0}, {9.0, -9.0}, {7.0, -0.5}},
           {{5.0, 30.0}, {9.0, 30.0}, {7.0, 1e9}},
           {{5.0, 5.0}, {9.0, nan}, {7.0, 9.0}},
           {{5.0, 5.0}, {infinity, 5.0}, {7.0, 9.0}},
           {{5.0, 5.0}, {9.0, -1e300}, {7.0, 9.0}},
       }) {
    EXPECT_EQ(area(contour), 0.0);
  }
}

}  // namespace
}  // namespace loopstone
