#include "loopstone/localization/landmark_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

TEST(LandmarkMap, WithinIsWhatLookingAtAllFinds) {
  Rng rng(1);
  std::vector<MappedLandmark> landmarks;
  for (int i = 0; i < 200; ++i) {
    landmarks.push_back({i, {std::round(rng.uniform(-5.0, 5.0)), rng.uniform(-5.0, 5.0)}});
  }
  const LandmarkMap map(landmarks);
  for (int trial = 0; trial < 100; ++trial) {
    const Eigen::Vector2d point(std::round(rng.uniform(-6.0, 6.0)), rng.uniform(-6.0, 6.0));
    const double reach = rng.uniform(0.0, 4.0);
    std::vector<std::size_t> expected;
    for (std::size_t i = 0; i < map.size(); ++i) {
      if ((map[i].position - point).norm() <= reach) expected.push_back(i);
    }
    EXPECT_EQ(map.within(point, reach), expected);
  }
}

TEST(LandmarkMap, KnowsItsNumbersAndSizes) {
  const LandmarkMap map({{7, {1.0, 2.0}, 0.1, 0.0}, {-3, {4.0, 5.0}, 0.0, 0.2}});
  EXPECT_EQ(map.index_of(7), 0U);
  EXPECT_EQ(map.index_of(-3), 1U);
  EXPECT_EQ(map.index_of(1), std::nullopt);
  EXPECT_EQ(map.largest_sigma_m(), 0.1);
  EXPECT_EQ(map.largest_radius_m(), 0.2);
}

TEST(LandmarkMap, RefusesWhatIsNoMap) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto make = [](std::vector<MappedLandmark> landmarks) {
    return LandmarkMap(std::move(landmarks));
  };
  EXPECT_THROW(make({}), UsageError);
  EXPECT_THROW(make({{1, {0.0, kNan}}}), UsageError);
  EXPECT_THROW(make({{1, {0.0, 0.0}, -0.1}}), UsageError);
  EXPECT_THROW(make({{1, {0.0, 0.0}, 0.0, kNan}}), UsageError);
  EXPECT_THROW(make({{1, {0.0, 0.0}}, {1, {1.0, 0.0}}}), UsageError);
}

}  // namespace
}  // namespace loopstone
