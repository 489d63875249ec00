#include "loopstone/registration/point_index.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

template <int kDimension>
using Points = std::vector<Eigen::Matrix<double, kDimension, 1>>;

template <int kDimension>
Points<kDimension> random_points(std::size_t count, Rng& rng) {
  Points<kDimension> points(count);
  for (auto& point : points) {
    for (int k = 0; k < kDimension; ++k) point(k) = rng.uniform(-3.0, 3.0);
  }
  return points;
}

/// \param repeated  how often each of some points stands among the others
template <int kDimension>
void expect_same_as_brute_force(int repeated) {
  Rng rng(21);
  auto points = random_points<kDimension>(200, rng);
  for (int i = 0; i < repeated; ++i) {
    for (const std::size_t k : {3, 90, 141}) points.push_back(points[k]);
  }
  const PointIndex<kDimension> index(points);
  for (const auto& query : random_points<kDimension>(100, rng)) {
    std::vector<double> distances;
    for (const auto& point : points) distances.push_back((point - query).norm());
    std::vector<double> sorted = distances;
    std::sort(sorted.begin(), sorted.end());

    const auto nearest = index.nearest(query, 1.0);
    ASSERT_EQ(nearest.has_value(), sorted.front() <= 1.0);
    if (nearest) {
      EXPECT_DOUBLE_EQ(nearest->distance_m, sorted.front());
      const auto first = std::find(distances.begin(), distances.end(), sorted.front());
      EXPECT_EQ(nearest->index, static_cast<std::size_t>(first - distances.begin()));
    }
    const auto several = index.nearest_several(query, 7);
    ASSERT_EQ(several.size(), 7U);
    for (std::size_t i = 0; i < several.size(); ++i) {
      EXPECT_DOUBLE_EQ(several[i].distance_m, sorted[i]);
    }
  }
}

TEST(PointIndex, FindsWhatBruteForceFindsInThePlane) {
  expect_same_as_brute_force<2>(0);
  expect_same_as_brute_force<2>(100);
}
TEST(PointIndex, FindsWhatBruteForceFindsInSpace) {
  expect_same_as_brute_force<3>(0);
  expect_same_as_brute_force<3>(100);
}

TEST(PointIndex, ManyPointsAtOnePlaceAreNoMoreWorkThanOne) {
  // Without care each question would visit every one of them: 10^11 steps.
  const PointIndex<2> index(Points<2>(300'000, Eigen::Vector2d(1.0, 2.0)));
  for (int i = 0; i < 300'000; ++i) {
    ASSERT_EQ(index.nearest({1.0, 2.0 + 1e-6 * i}, 1.0)->index, 0U);
    ASSERT_EQ(index.nearest_several({0.5, 2.0}, 3)[2].index, 2U);
  }
}

TEST(PointIndex, IsEmptyWhenNothingIsFinite) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const PointIndex<2> index({{kInfinity, 0.0}, {0.0, std::nan("")}});
  EXPECT_FALSE(index.nearest({0.0, 0.0}, 1e9).has_value());
  EXPECT_TRUE(index.nearest_several({0.0, 0.0}, 3).empty());
  EXPECT_FALSE(PointIndex<2>({}).nearest({0.0, 0.0}, 1e9).has_value());
}

TEST(PointIndex, KeepsTheNumbersOfPointsBesideBadOnes) {
  const PointIndex<2> index({{std::nan(""), 0.0}, {1.0, 0.0}, {2.0, 0.0}});
  EXPECT_EQ(index.nearest({1.9, 0.0}, 1.0)->index, 2U);
  EXPECT_FALSE(index.nearest({std::nan(""), 0.0}, 1.0).has_value());
  EXPECT_EQ(index.nearest_several({0.0, 0.0}, 10).size(), 2U);
}

}  // namespace
}  // namespace loopstone
