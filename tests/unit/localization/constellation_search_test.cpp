#include "loopstone/localization/constellation_search.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "landmark_scene.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/pose_distance.hpp"

namespace loopstone {
namespace {

using test::hall_map;
using test::in_range;
using test::seen_from;

constexpr ClutterModel kClutter{.share = 0.05, .max_range_m = 12.0};

Pose2 somewhere(Rng& rng) {
  return {rng.uniform(-6.0, 6.0), rng.uniform(-6.0, 6.0), rng.uniform(-kPi, kPi)};
}

TEST(ConstellationSearch, FindsThePlaceWithoutNames) {
  const LandmarkMap map = hall_map();
  const ConstellationIndex index(map, 12.0);
  Rng rng(11);
  for (int trial = 0; trial < 40; ++trial) {
    const Pose2 truth = somewhere(rng);
    const auto landmarks = in_range(truth, map, 9.0);
    if (landmarks.size() < 4) continue;
    const auto seen = seen_from(truth, map, landmarks, false, rng);
    const ConstellationSearch found = index.search(seen, kClutter);
    ASSERT_FALSE(found.matches.empty());
    const ConstellationMatch& best = found.matches.front();
    EXPECT_TRUE(is_within(best.map_T_robot.pose, truth, 0.1, 0.02)) << "trial " << trial;
    EXPECT_GE(best.explained, static_cast<int>(landmarks.size()) - 1);
    EXPECT_GT(best.log_gain, 10.0);
    if (found.matches.size() > 1) {
      EXPECT_LT(found.matches[1].log_gain, best.log_gain - 3.0);
    }
  }
}

TEST(ConstellationSearch, HalfOfItMayBeClutter) {
  const LandmarkMap map = hall_map();
  const ConstellationIndex index(map, 12.0);
  Rng rng(12);
  for (int trial = 0; trial < 20; ++trial) {
    const Pose2 truth = somewhere(rng);
    auto seen = seen_from(truth, map, {1, 4, 6, 8}, false, rng);
    for (int i = 0; i < 4; ++i) {
      seen.push_back(observed(rng.uniform(1.0, 10.0), rng.uniform(-kPi, kPi), 0.02, 0.004));
    }
    const ConstellationSearch found = index.search(seen, kClutter);
    ASSERT_FALSE(found.matches.empty());
    EXPECT_TRUE(is_within(found.matches.front().map_T_robot.pose, truth, 0.1, 0.03))
        << "trial " << trial;
  }
}

TEST(ConstellationSearch, TwoNamesAreEnough) {
  const LandmarkMap map = hall_map();
  const ConstellationIndex index(map, 12.0);
  Rng rng(13);
  const Pose2 truth{1.0, -2.0, 2.5};
  const auto found = index.search(seen_from(truth, map, {2, 5}, true, rng), kClutter);
  ASSERT_EQ(found.matches.size(), 1U);
  EXPECT_TRUE(is_within(found.matches[0].map_T_robot.pose, truth, 0.15, 0.03));
  // Without names two distances as long as theirs, or nearly, are others, too.
  const auto nameless = index.search(seen_from(truth, map, {2, 5}, false, rng), kClutter);
  EXPECT_GE(nameless.matches.size(), 2U) << "at least with both ends exchanged";
}

TEST(ConstellationSearch, ASquareLooksTheSameFromFourSides) {
  const LandmarkMap map({{1, {5.0, 5.0}}, {2, {-5.0, 5.0}}, {3, {-5.0, -5.0}}, {4, {5.0, -5.0}}});
  const ConstellationIndex index(map, 20.0);
  Rng rng(14);
  const Pose2 truth{1.0, 2.0, 0.3};
  const auto found = index.search(seen_from(truth, map, {0, 1, 2, 3}, false, rng), kClutter);
  ASSERT_EQ(found.matches.size(), 4U);
  for (int turn = 0; turn < 4; ++turn) {
    const Pose2 turned = Pose2{0.0, 0.0, wrap_angle(turn * kPi / 2.0)} * truth;
    const bool is_there = std::ranges::any_of(found.matches, [&](const ConstellationMatch& match) {
      return is_within(match.map_T_robot.pose, turned, 0.1, 0.02);
    });
    EXPECT_TRUE(is_there) << "turn " << turn;
  }
  EXPECT_NEAR(found.matches.front().log_gain, found.matches.back().log_gain, 1e-6);
}

/// log p of what was seen from a pose, each observation of its best landmark or clutter.
double log_likelihood(const Pose2& pose, const LandmarkMap& map,
                      const std::vector<LandmarkObservation>& seen) {
  double sum = 0.0;
  for (const LandmarkObservation& observation : seen) {
    double best = kClutter.log_clutter();
    for (const MappedLandmark& landmark : map.landmarks()) {
      const LinearSighting linear = linearised(pose, observation, landmark);
      const double chi2 = linear.innovation.dot(linear.noise.inverse() * linear.innovation);
      best = std::max(best,
                      kClutter.log_landmark() - 0.5 * (chi2 + std::log(linear.noise.determinant()) +
                                                       2.0 * std::log(2.0 * kPi)));
    }
    sum += best;
  }
  return sum;
}

TEST(ConstellationSearch, NoPoseOfAFineGridIsMoreProbable) {
  const LandmarkMap map = hall_map();
  const ConstellationIndex index(map, 12.0);
  Rng rng(15);
  for (int trial = 0; trial < 2; ++trial) {
    const Pose2 truth = somewhere(rng);
    auto seen = seen_from(truth, map, {0, 2, 6}, false, rng);
    // Coarser eyes, so that a grid can hit what they see.
    for (LandmarkObservation& observation : seen) {
      observation.covariance = 0.3 * 0.3 * Eigen::Matrix2d::Identity();
    }
    const ConstellationSearch found = index.search(seen, kClutter);
    ASSERT_FALSE(found.matches.empty());
    double best_found = -std::numeric_limits<double>::infinity();
    for (const ConstellationMatch& match : found.matches) {
      best_found = std::max(best_found, log_likelihood(match.map_T_robot.pose, map, seen));
    }
    double best_of_grid = -std::numeric_limits<double>::infinity();
    for (double x = -12.0; x <= 12.0; x += 0.25) {
      for (double y = -12.0; y <= 12.0; y += 0.25) {
        for (double yaw = -kPi; yaw < kPi; yaw += 0.05) {
          best_of_grid = std::max(best_of_grid, log_likelihood({x, y, yaw}, map, seen));
        }
      }
    }
    EXPECT_GE(best_found, best_of_grid - 1e-9) << "trial " << trial;
  }
}

TEST(ConstellationSearch, OneObservationTellsNoPlace) {
  const LandmarkMap map = hall_map();
  const ConstellationIndex index(map, 12.0);
  Rng rng(16);
  EXPECT_TRUE(index.search(seen_from({}, map, {0}, true, rng), kClutter).matches.empty());
  EXPECT_TRUE(index.search({}, kClutter).matches.empty());
}

TEST(ConstellationSearch, TooManyPairsAreRefusedInWords) {
  std::vector<MappedLandmark> landmarks;
  for (int i = 0; i < 6500; ++i) landmarks.push_back({i, {0.01 * i, (i % 7) * 1.0}});
  const LandmarkMap map(landmarks);
  EXPECT_THROW(ConstellationIndex(map, 100.0), UsageError);
  EXPECT_NO_THROW(ConstellationIndex(map, 1.0));
}

}  // namespace
}  // namespace loopstone
