#include "loopstone/localization/landmark_belief.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "landmark_scene.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/pose_distance.hpp"

namespace loopstone {
namespace {

using test::about;
using test::hall_map;
using test::seen_from;

constexpr ClutterModel kClutter{.share = 0.05, .max_range_m = 12.0};

double sum_of(const LandmarkBelief& belief) {
  double sum = belief.rest();
  for (const LandmarkPlace& place : belief.places()) sum += place.weight;
  return sum;
}

TEST(LandmarkBelief, WeightsAreThoseOfBayes) {
  // Two places; what is seen is of landmarks that lie a little otherwise about each.
  const LandmarkMap map({{1, {3.0, 0.0}}, {2, {20.0, 0.04}}});
  LandmarkBelief belief(map, kClutter);
  belief.start_at(about({}, 0.01, 0.01));
  const ConstellationMatch other{about({17.0, 0.0, 0.0}, 0.01, 0.01), 2, 3.0};
  EXPECT_EQ(belief.add(std::span(&other, 1)), 1);
  std::vector<LandmarkPlace> before = belief.places();
  ASSERT_EQ(before.size(), 2U);
  const double rest = belief.rest();
  const std::vector seen{observed(3.0, 0.005, 0.02, 0.004)};
  belief.update(seen);
  // By hand: weight x (1 - c) N(v; 0, H P H^T + R) for each place, rest x 1 / area.
  std::vector<double> expected;
  for (const LandmarkPlace& place : before) {
    const std::size_t landmark = place.map_T_robot.pose.x < 1.0 ? 0 : 1;
    const LandmarkPosterior posterior =
        update_by_landmarks(place.map_T_robot, map, seen, {landmark});
    expected.push_back(place.weight * 0.95 * std::exp(posterior.log_evidence));
  }
  const double of_rest = rest / (kPi * 144.0);
  const double sum = expected[0] + expected[1] + of_rest;
  for (const LandmarkPlace& place : belief.places()) {
    const std::size_t i = before[0].id == place.id ? 0 : 1;
    EXPECT_NEAR(place.weight, expected[i] / sum, 1e-9);
  }
  EXPECT_NEAR(belief.rest(), of_rest / sum, 1e-9);
  EXPECT_NEAR(sum_of(belief), 1.0, 1e-12);
}

TEST(LandmarkBelief, ARobotCarriedAwayIsLostAndFoundElsewhere) {
  const LandmarkMap map = hall_map();
  const ConstellationIndex index(map, 12.0);
  Rng rng(2);
  LandmarkBelief belief(map, kClutter);
  const Pose2 first{1.0, 1.0, 0.3};
  belief.start_at(about(first, 0.3, 0.1));
  belief.update(seen_from(first, map, {0, 1, 2, 3}, false, rng));
  EXPECT_LT(belief.rest(), 1e-3);
  EXPECT_TRUE(is_within(belief.places()[0].map_T_robot.pose, first, 0.05, 0.01));

  const Pose2 elsewhere{-3.0, -2.0, 2.0};
  const auto seen = seen_from(elsewhere, map, {4, 5, 6, 7}, false, rng);
  belief.update(seen);
  EXPECT_GT(belief.rest(), 0.1) << "four that no place explains";
  LandmarkBelief unaided = belief;
  unaided.update(seen);
  EXPECT_GT(unaided.rest(), 0.99) << "and again";
  const ConstellationSearch found = index.search(seen, kClutter);
  EXPECT_GE(belief.add(found.matches), 1);
  EXPECT_TRUE(is_within(belief.places()[0].map_T_robot.pose, elsewhere, 0.1, 0.03));
  EXPECT_GT(belief.places()[0].weight, 0.9);
}

TEST(LandmarkBelief, OneThatIsClutterMovesNothing) {
  const LandmarkMap map = hall_map();
  Rng rng(3);
  LandmarkBelief belief(map, kClutter);
  belief.start_at(about({}, 0.02, 0.01));
  auto seen = seen_from({}, map, {0, 2}, false, rng);
  belief.update(seen);
  const Pose2 pose = belief.places()[0].map_T_robot.pose;
  belief.update(std::vector{observed(3.0, 3.0, 0.02, 0.004)});
  EXPECT_EQ(belief.places()[0].map_T_robot.pose, pose);
  EXPECT_EQ(belief.places()[0].explained, 0);
  EXPECT_LT(belief.rest(), 0.01);
}

TEST(LandmarkBelief, PlacesThatLookAlikeStayUntilTheyDiffer) {
  const LandmarkMap map(
      {{1, {5.0, 5.0}}, {2, {-5.0, 5.0}}, {3, {-5.0, -5.0}}, {4, {5.0, -5.0}}, {5, {7.0, 0.0}}});
  const ConstellationIndex index(map, 20.0);
  Rng rng(4);
  LandmarkBelief belief(map, kClutter);
  const Pose2 truth{1.0, 2.0, 0.3};
  const auto corners = seen_from(truth, map, {0, 1, 2, 3}, false, rng);
  belief.add(index.search(corners, kClutter).matches);
  ASSERT_EQ(belief.places().size(), 4U);
  EXPECT_NEAR(belief.places()[0].weight, 0.25, 0.01);
  belief.update(seen_from(truth, map, {4}, false, rng));
  EXPECT_GT(belief.places()[0].weight, 0.95);
  EXPECT_TRUE(is_within(belief.places()[0].map_T_robot.pose, truth, 0.05, 0.01));
}

TEST(LandmarkBelief, TheSameThingsSeenAgainProveNothing) {
  // A place that explains one thing and not another, looked at by a robot that stands still.
  const LandmarkMap map({{1, {3.0, 0.0}}, {2, {50.0, 0.0}}});
  const std::vector seen{observed(3.0, 0.0, 0.02, 0.004), observed(5.0, 1.0, 0.02, 0.004)};
  const auto rest_after = [&](bool is_seen_before) {
    LandmarkBelief belief(map, kClutter);
    const ConstellationMatch match{about({}, 0.01, 0.005), 2, 2.0};
    belief.add(std::span(&match, 1));
    for (int i = 0; i < 20; ++i) {
      std::vector<BlindExpectation> expected;
      for (const LandmarkObservation& observation : seen) {
        const double peak =
            -0.5 * std::log((2.0 * observation.covariance).determinant()) - std::log(2.0 * kPi);
        expected.push_back({is_seen_before ? peak : kClutter.log_anywhere(), is_seen_before});
      }
      belief.update(seen, expected);
    }
    return belief.rest();
  };
  EXPECT_LT(rest_after(false), 1e-9) << "were they new each time";
  EXPECT_GT(rest_after(true), 0.01);
  EXPECT_LT(rest_after(true), 0.9);
}

TEST(LandmarkBelief, KnownPlacesAreNotAddedAgain) {
  const LandmarkMap map = hall_map();
  LandmarkBelief belief(map, kClutter);
  const ConstellationMatch match{about({1.0, 1.0, 0.0}, 0.01, 0.01), 3, 8.0};
  EXPECT_EQ(belief.add(std::span(&match, 1)), 1);
  const double weight = belief.places()[0].weight;
  EXPECT_EQ(belief.add(std::span(&match, 1)), 0);
  EXPECT_NEAR(belief.places()[0].weight, weight, 1e-12);
  EXPECT_NEAR(weight, std::exp(8.0) / (1.0 + std::exp(8.0)), 1e-12);
  // One that had lost its weight gets what a search would give it, and its pose.
  belief.update(std::vector{observed(2.0, 3.0, 0.01, 0.001), observed(5.0, 2.5, 0.01, 0.001),
                            observed(1.0, 2.0, 0.01, 0.001)});
  EXPECT_LT(belief.places()[0].weight, 0.3);
  const ConstellationMatch better{about({1.05, 1.0, 0.0}, 0.01, 0.01), 3, 12.0};
  EXPECT_EQ(belief.add(std::span(&better, 1)), 0);
  EXPECT_GT(belief.places()[0].weight, 0.99);
  EXPECT_EQ(belief.places()[0].map_T_robot.pose.x, 1.05);
}

TEST(LandmarkBelief, MotionIsCompounding) {
  const LandmarkMap map = hall_map();
  LandmarkBelief belief(map, kClutter);
  const PoseWithCovariance2 start = about({1.0, 2.0, 0.5}, 0.1, 0.02);
  const PoseWithCovariance2 motion = about({0.3, 0.0, 0.1}, 0.01, 0.005);
  belief.start_at(start);
  belief.predict(motion);
  const PoseWithCovariance2 expected = compound(start, motion);
  EXPECT_EQ(belief.places()[0].map_T_robot.pose, expected.pose);
  EXPECT_EQ(belief.places()[0].map_T_robot.covariance, expected.covariance);
}

}  // namespace
}  // namespace loopstone
