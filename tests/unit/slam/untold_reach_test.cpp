#include "loopstone/slam/untold_reach.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/registration/correlative_search.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using test::pose_near;

/// After a second and a half of silence 8 m were told, with a turn.
UntoldReach swinging() {
  return {.frame_T_start = {3.0, -2.0, 0.7},
          .ahead_m = 0.5,
          .half_xy_m = 0.9,
          .half_yaw_rad = 1.4,
          .sigma_m = 0.6,
          .sigma_rad = 0.5,
          .after = {7.0, 4.0, 1.1}};
}

Pose2 after_motion(const UntoldReach& reach, const Pose2& untold) {
  return reach.frame_T_start * Pose2{reach.ahead_m, 0.0, 0.0} * untold * reach.after;
}

TEST(UntoldReach, TellsTheMotionThatNobodySaw) {
  const Pose2 untold{0.3, -0.2, 0.9};
  const UntoldReach reach = swinging();
  EXPECT_TRUE(pose_near(reach.untold(after_motion(reach, untold)), untold, 1e-9, 1e-9));
  const Pose2 other_T_frame{-5.0, 1.0, -2.0};
  EXPECT_TRUE(pose_near((other_T_frame * reach).untold(other_T_frame * after_motion(reach, untold)),
                        untold, 1e-9, 1e-9))
      << "in whatever frame";
}

TEST(UntoldReach, HoldsWhatTheMotionMayHaveBeen) {
  const UntoldReach reach = swinging();
  EXPECT_TRUE(reach.holds(after_motion(reach, {0.85, -0.85, 1.3})));
  EXPECT_FALSE(reach.holds(after_motion(reach, {0.95, 0.0, 0.0})));
  EXPECT_FALSE(reach.holds(after_motion(reach, {0.0, 0.0, -1.5})));
  // As near as another one that a turn leads to, but no turn leads there with that heading.
  Pose2 turned_back = after_motion(reach, {0.0, 0.0, 1.2});
  turned_back.yaw = wrap_angle(turned_back.yaw - 1.2);
  EXPECT_FALSE(reach.holds(turned_back));
}

TEST(UntoldReach, WindowsCoverAllOfIt) {
  for (const bool swings : {true, false}) {
    UntoldReach reach = swinging();
    if (!swings) reach.after = {0.2, 0.0, 0.3};
    const std::vector<SearchWindow> windows = reach.windows();
    EXPECT_EQ(windows.size() > 1, swings);
    for (const SearchWindow& window : windows)
      EXPECT_LT(window.half_xy_m, 3.0) << "they are small where one would be 10 m wide";
    Rng rng(7);
    for (int i = 0; i < 2000; ++i) {
      const Pose2 pose = after_motion(
          reach, {rng.uniform(-0.9, 0.9), rng.uniform(-0.9, 0.9), rng.uniform(-1.4, 1.4)});
      ASSERT_TRUE(reach.holds(pose));
      const bool is_covered = std::ranges::any_of(windows, [&](const SearchWindow& window) {
        const Eigen::Vector2d off = pose.translation() - window.centre.translation();
        // Motions lie in a square about the start's axes, windows in one about the frame's.
        return off.cwiseAbs().maxCoeff() <= std::sqrt(2.0) * window.half_xy_m &&
               std::abs(wrap_angle(pose.yaw - window.centre.yaw)) <= window.half_yaw_rad + 1e-9;
      });
      ASSERT_TRUE(is_covered) << pose.x << " " << pose.y << " " << pose.yaw;
    }
  }
}

TEST(UntoldReach, WhoWasCarriedIsLookedForFacingEachWayByItself) {
  const UntoldReach reach{.frame_T_start = {3.0, -2.0, 0.7},
                          .half_xy_m = 6.0,
                          .half_yaw_rad = 3.6,
                          .sigma_m = 3.0,
                          .sigma_rad = 1.8,
                          .is_carried = true};
  const std::vector<SearchWindow> windows = reach.windows();
  EXPECT_GE(windows.size(), 9U);
  double turned_rad = 0.0;
  for (const SearchWindow& window : windows) {
    EXPECT_LE(window.half_yaw_rad, kUntoldReach.carried_slice_rad);
    EXPECT_EQ(window.half_xy_m, reach.half_xy_m);
    EXPECT_LT((window.centre.translation() - reach.frame_T_start.translation()).norm(), 1e-12);
    turned_rad += 2.0 * window.half_yaw_rad;
  }
  EXPECT_NEAR(turned_rad, 2.0 * kPi, 1e-9) << "once around";
}

TEST(UntoldReach, ATurnMovesWhatCameAfter) {
  UntoldReach reach = swinging();
  reach.sigma_m = 0.02;
  const double turn_rad = 0.01;  // small, so that what it does is linear
  const Pose2 middle = after_motion(reach, {});
  Eigen::Matrix3d sampled = Eigen::Matrix3d::Zero();
  Rng rng(3);
  const int count = 20000;
  for (int i = 0; i < count; ++i) {
    const Pose2 pose = after_motion(reach, {reach.sigma_m * rng.normal(),
                                            reach.sigma_m * rng.normal(), turn_rad * rng.normal()});
    const Eigen::Vector3d off(pose.x - middle.x, pose.y - middle.y,
                              wrap_angle(pose.yaw - middle.yaw));
    sampled += off * off.transpose() / count;
  }
  const Eigen::Matrix3d told = reach.covariance(middle, turn_rad);
  EXPECT_LT((sampled - told).norm(), 0.05 * told.norm());
  EXPECT_GT(std::abs(told(0, 2)), 0.5 * turn_rad * std::sqrt(told(0, 0))) << "they go together";
}

}  // namespace
}  // namespace loopstone
