#include "loopstone/slam/odom_frame.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/pose_near.hpp"
#include "support/saved_state.hpp"

namespace loopstone {
namespace {

using test::pose_near;
using test::restored;

TEST(OdomFrame, GoesOnWithTheRobotAndNeverJumps) {
  OdomFrame frame;
  EXPECT_EQ(frame.follow({0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, false), Pose2{});
  // Expected 0.1 m on, found 3 m away: it goes on by 0.1 m.
  const Pose2 found = frame.follow({3.0, 0.0, 0.0}, {0.1, 0.0, 0.0}, true);
  EXPECT_TRUE(pose_near(found, {0.1, 0.0, 0.0}, 1e-12, 1e-12));
  EXPECT_TRUE(pose_near(frame.local_T_odom(), {2.9, 0.0, 0.0}, 1e-12, 1e-12));
  // What is only refined goes all into the robot's motion.
  const Pose2 refined = frame.follow({3.2, 0.0, 0.0}, {3.1, 0.0, 0.0}, false);
  EXPECT_TRUE(pose_near(refined, {0.3, 0.0, 0.0}, 1e-12, 1e-12));
}

TEST(OdomFrame, GoesOnFromItsState) {
  OdomFrame frame;
  (void)frame.follow({0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, false);
  (void)frame.follow({3.0, 0.0, 1.0}, {0.1, 0.0, 0.0}, true);
  OdomFrame again = restored(frame, OdomFrame{});
  EXPECT_EQ(again.follow({5.0, 0.0, 1.0}, {3.1, 0.0, 1.0}, true),
            frame.follow({5.0, 0.0, 1.0}, {3.1, 0.0, 1.0}, true));
  EXPECT_EQ(again.local_T_odom(), frame.local_T_odom());
  EXPECT_TRUE(
      test::refuses(frame, [](OdomFrame::State& state) { state.local_T_odom.x = std::nan(""); }));
  EXPECT_TRUE(test::refuses(
      frame, [](OdomFrame::State& state) { state.last_local_T_robot->yaw = std::nan(""); }));
}

}  // namespace
}  // namespace loopstone
