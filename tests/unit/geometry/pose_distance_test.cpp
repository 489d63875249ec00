#include "loopstone/geometry/pose_distance.hpp"

#include <gtest/gtest.h>

namespace loopstone {
namespace {

TEST(PoseDistance, CountsPositionAndHeadingEach) {
  const Pose2 pose{1.0, 2.0, 0.5};
  EXPECT_TRUE(is_within(pose, {1.3, 2.4, 0.6}, 0.51, 0.11));
  EXPECT_FALSE(is_within(pose, {1.3, 2.4, 0.6}, 0.49, 0.11));
  EXPECT_FALSE(is_within(pose, {1.3, 2.4, 0.6}, 0.51, 0.09));
  EXPECT_FALSE(is_within(pose, pose, 0.0, 1.0));
}

TEST(PoseDistance, GoesTheShortWayRound) {
  EXPECT_TRUE(is_within({0.0, 0.0, kPi - 0.01}, {0.0, 0.0, -kPi + 0.01}, 0.1, 0.03));
}

}  // namespace
}  // namespace loopstone
