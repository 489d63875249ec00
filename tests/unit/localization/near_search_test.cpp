#include "localization/near_search.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <vector>

#include "drawn_room.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using test::drawn;
using test::furnished_room;
using test::pose_near;
using test::scan_from;
using test::Walls;

const Eigen::Vector2d kLow{0.0, 0.0};
const Eigen::Vector2d kHigh{8.0, 6.0};
const Pose2 kMount{0.2, 0.05, 0.1};

LocalizationScan view_from(const Walls& walls, const Pose2& pose) {
  return view_for_localization(scan_from(walls, pose, kMount, {}), kMount, Tangent2::Zero(), 90);
}

PoseWithCovariance2 known_to(const Pose2& pose, double sigma_m, double sigma_rad) {
  PoseWithCovariance2 known{.pose = pose};
  known.covariance.diagonal() << sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad;
  return known;
}

TEST(NearSearch, FindsARobotThatSlippedAndTurned) {
  const Walls room = furnished_room();
  const LocalizationMap map(drawn(room, kLow, kHigh));
  const Pose2 truth{3.0, 3.0, 0.3};
  for (const Pose2& slip : {Pose2{0.4, -0.3, 0.0}, Pose2{0.0, 0.0, 0.5}, Pose2{-0.3, 0.3, -0.4}}) {
    const auto found =
        find_nearby(view_from(room, truth), map, known_to(truth * slip, 0.02, 0.01), 0.8);
    ASSERT_TRUE(found);
    EXPECT_TRUE(pose_near(found->pose, truth, 0.05, 0.02));
    EXPECT_GT(found->covariance.determinant(), 0.0);
  }
}

TEST(NearSearch, LooksAsFarAsThePoseIsUncertain) {
  const Walls room = furnished_room();
  const LocalizationMap map(drawn(room, kLow, kHigh));
  const Pose2 truth{2.0, 3.0, 0.3};
  const Pose2 foretold = truth * Pose2{1.6, 0.0, 0.0};
  const LocalizationScan view = view_from(room, truth);
  EXPECT_FALSE(find_nearby(view, map, known_to(foretold, 0.02, 0.01), 0.8));
  const auto found = find_nearby(view, map, known_to(foretold, 0.5, 0.01), 0.8);
  ASSERT_TRUE(found);
  EXPECT_TRUE(pose_near(found->pose, truth, 0.05, 0.02));
}

TEST(NearSearch, AlongACorridorNoPoseIsTheOnlyOne) {
  const Walls corridor = {{{-50.0, 0.025}, {150.0, 0.025}}, {{-50.0, 2.025}, {150.0, 2.025}}};
  const LocalizationMap map(drawn(corridor, {-20.0, 0.0}, {40.0, 2.0}));
  const Pose2 truth{5.0, 1.0, 0.0};
  EXPECT_FALSE(find_nearby(view_from(corridor, truth), map, known_to(truth, 0.5, 0.05), 0.6));
}

TEST(NearSearch, WhatFitsNowhereIsNotFound) {
  const LocalizationMap map(drawn(furnished_room(), kLow, kHigh));
  const Pose2 pose{3.0, 3.0, 0.3};
  const Walls elsewhere = test::rectangle({2.2, 2.4}, {4.1, 3.4});
  EXPECT_FALSE(find_nearby(view_from(elsewhere, pose), map, known_to(pose, 0.1, 0.05), 0.6));
}

TEST(Quality, PeopleCountLittleAndWallsDrivenThroughMuch) {
  const BeamFit good{.explained = 1.0, .known = 1.0};
  const BeamFit crowded{.explained = 0.6, .unexpected = 0.4, .known = 1.0};
  const BeamFit wrong{.explained = 0.6, .violations = 0.4, .known = 1.0};
  EXPECT_DOUBLE_EQ(quality_of(good), 1.0);
  EXPECT_GT(quality_of(crowded), 0.9);
  EXPECT_LT(quality_of(wrong), 0.25);
}

TEST(NearSearchPace, LooksAtOnceThenEverMoreSeldomUntilItFinds) {
  NearSearchPace pace;
  std::vector<int> looks;
  for (int scan = 0; scan < 60; ++scan) {
    if (!pace.due()) continue;
    looks.push_back(scan);
    pace.in_vain();
  }
  ASSERT_GE(looks.size(), 5U);
  EXPECT_EQ(looks.front(), 0);
  for (std::size_t i = 2; i + 1 < looks.size(); ++i)
    EXPECT_GE(looks[i + 1] - looks[i], looks[i] - looks[i - 1]);
  pace.found();
  EXPECT_TRUE(pace.due());
}

}  // namespace
}  // namespace loopstone
