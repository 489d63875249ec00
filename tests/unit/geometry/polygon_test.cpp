#include "loopstone/geometry/polygon.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

using testing::HasSubstr;
using testing::Optional;

/// Like an L, which its own middle need not lie in.
Polygon2 hook() {
  return {{{0.0, 0.0}, {4.0, 0.0}, {4.0, 1.0}, {1.0, 1.0}, {1.0, 3.0}, {0.0, 3.0}}};
}

TEST(Polygon, ContainsWhatLiesWithinItsSides) {
  EXPECT_TRUE(contains(hook(), {0.5, 2.5}));
  EXPECT_TRUE(contains(hook(), {3.5, 0.5}));
  EXPECT_FALSE(contains(hook(), {2.0, 2.0}));
  EXPECT_FALSE(contains(hook(), {-0.1, 0.5}));
  EXPECT_FALSE(contains(hook(), {4.5, 0.5}));
}

TEST(Polygon, AreaAndMiddleAreThoseOfItsParts) {
  // 4 m x 1 m with its middle at (2, 0.5), and 1 m x 2 m with its middle at (0.5, 2).
  EXPECT_NEAR(area_of(hook()), 6.0, 1e-12);
  EXPECT_NEAR(centroid_of(hook()).x(), (4.0 * 2.0 + 2.0 * 0.5) / 6.0, 1e-12);
  EXPECT_NEAR(centroid_of(hook()).y(), (4.0 * 0.5 + 2.0 * 2.0) / 6.0, 1e-12);
}

TEST(Polygon, IsTheSameEitherWayRoundAndFarFromTheOrigin) {
  Polygon2 other = hook();
  std::ranges::reverse(other.corners);
  EXPECT_NEAR(area_of(other), 6.0, 1e-12);
  const Pose2 far{1e5, -2e5, 0.0};
  EXPECT_NEAR(area_of(far * hook()), 6.0, 1e-6);
  EXPECT_NEAR((centroid_of(far * other) - far * centroid_of(hook())).norm(), 0.0, 1e-6);
}

TEST(Polygon, MovesWithWhatItContains) {
  Rng rng(7);
  const Pose2 moved{3.0, -2.0, 1.1};
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2d point(rng.uniform(-1.0, 5.0), rng.uniform(-1.0, 4.0));
    EXPECT_EQ(contains(moved * hook(), moved * point), contains(hook(), point));
  }
}

TEST(Polygon, SaysWhatIsWrongWithIt) {
  EXPECT_FALSE(fault_of(hook()).has_value());
  EXPECT_FALSE(fault_of(box_polygon({0.0, 0.0}, {1.0, 2.0})).has_value());
  EXPECT_THAT(fault_of({{{0.0, 0.0}, {1.0, 0.0}}}), Optional(HasSubstr("three corners")));
  EXPECT_THAT(fault_of({{{0.0, 0.0}, {1.0, 0.0}, {2.0, 0.0}}}), Optional(HasSubstr("an area")));
  EXPECT_THAT(fault_of({{{0.0, 0.0}, {2.0, 2.0}, {2.0, 0.0}, {0.0, 2.0}}}),
              Optional(HasSubstr("cross")));
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(fault_of({{{0.0, 0.0}, {2.0, none}, {2.0, 0.0}}}), Optional(HasSubstr("numbers")));
}

}  // namespace
}  // namespace loopstone
