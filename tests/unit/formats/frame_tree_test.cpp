// Frames of a robot, by tf.

#include "formats/frame_tree.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>

#include "loopstone/geometry/angle.hpp"
#include "support/generators.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using test::pose_near;
using testing::ElementsAre;

Stamp at(double seconds) { return Stamp::from_seconds(seconds); }
Pose3 shifted(double x, double y = 0.0, double z = 0.0) { return {{x, y, z}}; }
Pose3 turned(double yaw) { return Pose3::from_roll_pitch_yaw({0, 0, 0}, 0, 0, yaw); }

TEST(FrameTree, GoesUpAndDownTheTree) {
  FrameTree tree;
  tree.add_fixed("base_footprint", "base_link", shifted(0, 0, 0.1));
  tree.add_fixed("base_link", "laser", shifted(0.3, 0, 0.2) * turned(kPi / 2));
  tree.add_fixed("base_link", "imu", shifted(-0.1));
  EXPECT_TRUE(pose_near(*tree.find("base_footprint", "laser"),
                        shifted(0.3, 0, 0.3) * turned(kPi / 2), 1e-12, 1e-12));
  EXPECT_TRUE(
      pose_near(*tree.find("imu", "laser"), shifted(0.4, 0, 0.2) * turned(kPi / 2), 1e-12, 1e-12));
  EXPECT_TRUE(pose_near(*tree.find("laser", "laser"), Pose3{}, 0.0, 0.0));
  EXPECT_THAT(tree.ancestry("laser"), ElementsAre("laser", "base_link", "base_footprint"));
  EXPECT_EQ(tree.parent_of("imu"), "base_link");
  EXPECT_FALSE(tree.parent_of("base_footprint"));
  EXPECT_TRUE(tree.has("base_footprint"));
  EXPECT_FALSE(tree.has("camera"));
  EXPECT_FALSE(tree.find("camera", "laser"));
  tree.add_fixed("elsewhere", "camera", {});
  EXPECT_FALSE(tree.find("camera", "laser")) << "not connected";
}

TEST(FrameTree, TakesTheSlashFromNames) {
  EXPECT_EQ(frame_name("/base_link"), "base_link");
  EXPECT_EQ(frame_name("//robot1/base_link"), "robot1/base_link");
  EXPECT_EQ(frame_name("/"), "");
  EXPECT_EQ(frame_name(""), "");
}

TEST(FrameTree, InterpolatesFramesThatMove) {
  FrameTree tree;
  tree.add("base", "tilt", at(10.0), shifted(0.0) * turned(0.0));
  tree.add("base", "tilt", at(11.0), shifted(1.0) * turned(1.0));
  ASSERT_TRUE(tree.moves("base", "tilt"));
  EXPECT_TRUE(
      pose_near(*tree.find("base", "tilt", at(10.25)), shifted(0.25) * turned(0.25), 1e-9, 1e-9));
  EXPECT_TRUE(pose_near(*tree.find("tilt", "base", at(10.25)),
                        (shifted(0.25) * turned(0.25)).inverse(), 1e-9, 1e-9));
  EXPECT_TRUE(
      pose_near(*tree.find("base", "tilt", at(11.9)), shifted(1.0) * turned(1.0), 1e-9, 1e-9));
  EXPECT_FALSE(tree.find("base", "tilt", at(12.1))) << "too long ago";
  EXPECT_TRUE(tree.find("base", "tilt", at(9.1)));
  EXPECT_FALSE(tree.find("base", "tilt", at(8.9)));
  EXPECT_TRUE(pose_near(*tree.find("base", "tilt"), shifted(1.0) * turned(1.0), 1e-9, 1e-9));
}

TEST(FrameTree, WhatNeverMovedIsAsGoodAsFixed) {
  FrameTree tree;
  for (int i = 0; i < 100; ++i) tree.add("base", "laser", at(10.0 + 0.1 * i), shifted(0.2));
  EXPECT_FALSE(tree.moves("base", "laser"));
  for (const double time : {0.0, 12.0, 1e6}) {
    EXPECT_TRUE(pose_near(*tree.find("base", "laser", at(time)), shifted(0.2), 0.0, 0.0));
  }
}

TEST(FrameTree, WhatStoodLongAndMovesNowIsKnownForTheTimeBefore) {
  FrameTree tree;
  for (int i = 0; i <= 600; ++i) tree.add("base", "tilt", at(0.1 * i), turned(0.0));
  tree.add("base", "tilt", at(60.1), turned(0.3));
  for (const double time : {0.5, 55.0, 60.0}) {
    const auto pose = tree.find("base", "tilt", at(time));
    ASSERT_TRUE(pose) << time;
    EXPECT_TRUE(pose_near(*pose, turned(0.0), 1e-12, 1e-12));
  }
  EXPECT_TRUE(pose_near(*tree.find("base", "tilt", at(60.05)), turned(0.15), 1e-9, 1e-9));
}

TEST(FrameTree, LateNewsOfFramesThatMoveAreLeftOut) {
  FrameTree tree;
  tree.add("base", "tilt", at(10.0), turned(0.0));
  tree.add("base", "tilt", at(11.0), turned(1.0));
  tree.add("base", "tilt", at(10.5), turned(-1.0));
  EXPECT_TRUE(pose_near(*tree.find("base", "tilt", at(10.5)), turned(0.5), 1e-9, 1e-9));
}

TEST(FrameTree, RefusesLoopsAndNothing) {
  FrameTree tree;
  tree.add_fixed("a", "a", {});
  tree.add_fixed("", "b", {});
  tree.add_fixed("a", "", {});
  EXPECT_FALSE(tree.has("a"));
  tree.add_fixed("a", "b", shifted(1));
  tree.add_fixed("b", "c", shifted(1));
  tree.add_fixed("c", "a", shifted(1));
  tree.add("c", "a", at(1.0), shifted(1));
  EXPECT_THAT(tree.ancestry("c"), ElementsAre("c", "b", "a"));
}

TEST(FrameTree, OfTwoParentsTheFirstIsBelieved) {
  FrameTree tree;
  tree.add_fixed("base", "laser", shifted(1));
  tree.add_fixed("other", "laser", shifted(2));
  tree.add("other", "laser", at(1), shifted(3));
  EXPECT_THAT(tree.contested(), ElementsAre("laser"));
  EXPECT_TRUE(pose_near(*tree.find("base", "laser"), shifted(1), 0.0, 0.0));
  EXPECT_FALSE(tree.find("other", "laser"));
}

TEST(FrameTree, FixedBeatsMoving) {
  FrameTree tree;
  tree.add("base", "laser", at(1), shifted(1));
  tree.add("base", "laser", at(2), shifted(2));
  tree.add_fixed("base", "laser", shifted(3));
  tree.add("base", "laser", at(3), shifted(4));
  EXPECT_FALSE(tree.moves("base", "laser"));
  EXPECT_TRUE(pose_near(*tree.find("base", "laser", at(2)), shifted(3), 0.0, 0.0));
}

TEST(FrameTree, StandingLeavesOutWhatMovedAndForgetsTimes) {
  FrameTree tree;
  tree.add("odom", "base", at(1e9), shifted(1));
  tree.add("odom", "base", at(1e9 + 1), shifted(2));
  tree.add("base", "laser", at(1e9), shifted(0.2));
  tree.add_fixed("laser", "optics", shifted(0.1));
  FrameTree standing = tree.standing();
  EXPECT_FALSE(standing.find("odom", "base"));
  EXPECT_TRUE(pose_near(*standing.find("base", "optics", at(5)), shifted(0.3), 1e-12, 1e-12));
  // Told again by another clock, it may begin to move.
  standing.add("base", "laser", at(5.0), shifted(0.2));
  standing.add("base", "laser", at(6.0), shifted(0.4));
  const auto between = standing.find("base", "laser", at(5.5));
  ASSERT_TRUE(between);
  EXPECT_TRUE(pose_near(*between, shifted(0.3), 1e-9, 1e-9));
}

TEST(FrameTree, RemembersSomeSecondsOfWhatMoves) {
  FrameTree tree;
  for (int i = 0; i <= 10'000; ++i) tree.add("odom", "base", at(0.01 * i), shifted(0.01 * i));
  const double kept_s = FrameTree::kKept.seconds();
  EXPECT_FALSE(tree.find("odom", "base", at(100.0 - kept_s - 1.5)));
  const auto pose = tree.find("odom", "base", at(100.0 - kept_s + 0.005));
  ASSERT_TRUE(pose);
  EXPECT_NEAR(pose->translation.x(), 100.0 - kept_s + 0.005, 1e-6);
}

TEST(FrameTree, ManyFramesAndParentsAreNoHarm) {
  FrameTree tree;
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < 20'000; ++i) {
    tree.add("f" + std::to_string(i % 300), "f" + std::to_string(i % 300 + 1), at(i), {});
    tree.add("parent" + std::to_string(i), "f1", at(i), {});
    tree.add("root", "x" + std::to_string(i), at(i), {});
  }
  EXPECT_FALSE(tree.has("parent7")) << "nothing is kept of a parent that is not believed";
  EXPECT_FALSE(tree.has("x19999"));
  EXPECT_THAT(tree.contested(), ElementsAre("f1"));
  EXPECT_TRUE(tree.find("f0", "f300"));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

RC_GTEST_PROP(FrameTreeLaw, ThereAndBackIsNothing, ()) {
  FrameTree tree;
  const int frames = *rc::gen::inRange(2, 12);
  for (int child = 1; child < frames; ++child) {
    const int parent = *rc::gen::inRange(0, child);
    const Pose3 pose = exp(*test::any_tangent3());
    const std::string name = std::to_string(child);
    if (*rc::gen::arbitrary<bool>()) {
      tree.add_fixed(std::to_string(parent), name, pose);
    } else {
      tree.add(std::to_string(parent), name, at(1.0), pose);
      tree.add(std::to_string(parent), name, at(2.0),
               pose * exp(Tangent3(0.1 * *test::any_tangent3())));
    }
  }
  const std::string a = std::to_string(*rc::gen::inRange(0, frames));
  const std::string b = std::to_string(*rc::gen::inRange(0, frames));
  const std::string c = std::to_string(*rc::gen::inRange(0, frames));
  const Stamp when = at(*test::between(0.5, 2.5));
  const auto a_T_b = tree.find(a, b, when);
  const auto b_T_a = tree.find(b, a, when);
  const auto b_T_c = tree.find(b, c, when);
  RC_ASSERT(a_T_b && b_T_a && b_T_c);
  RC_ASSERT(bool(pose_near(*a_T_b * *b_T_a, Pose3{}, 1e-9, 1e-7)));
  RC_ASSERT(bool(pose_near(*a_T_b * *b_T_c, *tree.find(a, c, when), 1e-9, 1e-7)));
}

}  // namespace
}  // namespace loopstone
