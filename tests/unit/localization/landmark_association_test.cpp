#include "loopstone/localization/landmark_association.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "landmark_scene.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

using test::about;
using test::hall_map;
using test::seen_from;

/// log p of a whole set of pairs: the joint normal density of all innovations, and clutter.
double joint_density(const PoseWithCovariance2& prior, const LandmarkMap& map,
                     const std::vector<LandmarkObservation>& seen,
                     const LandmarkAssociation& association, const ClutterModel& clutter) {
  std::vector<LinearSighting> pairs;
  double log_shares = 0.0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (association[i]) {
      pairs.push_back(linearised(prior.pose, seen[i], map[*association[i]]));
      log_shares += clutter.log_landmark();
    } else {
      log_shares += clutter.log_clutter();
    }
  }
  if (pairs.empty()) return log_shares;
  const auto rows = static_cast<Eigen::Index>(2 * pairs.size());
  Eigen::MatrixXd jacobian(rows, 3);
  Eigen::VectorXd innovation(rows);
  Eigen::MatrixXd noise = Eigen::MatrixXd::Zero(rows, rows);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(2 * i);
    jacobian.middleRows<2>(row) = pairs[i].jacobian;
    innovation.segment<2>(row) = pairs[i].innovation;
    noise.block<2, 2>(row, row) = pairs[i].noise;
  }
  const Eigen::MatrixXd spread = jacobian * prior.covariance * jacobian.transpose() + noise;
  return log_shares -
         0.5 * (innovation.dot(spread.inverse() * innovation) + std::log(spread.determinant()) +
                static_cast<double>(rows) * std::log(2.0 * kPi));
}

/// Every way to pair observations with landmarks, none used twice.
void try_all(const PoseWithCovariance2& prior, const LandmarkMap& map,
             const std::vector<LandmarkObservation>& seen, const ClutterModel& clutter,
             LandmarkAssociation& current, std::size_t at, double& best,
             LandmarkAssociation& best_set) {
  if (at == seen.size()) {
    const double log_density = joint_density(prior, map, seen, current, clutter);
    if (log_density <= best) return;
    best = log_density;
    best_set = current;
    return;
  }
  try_all(prior, map, seen, clutter, current, at + 1, best, best_set);
  for (std::size_t landmark = 0; landmark < map.size(); ++landmark) {
    const bool is_taken = std::count(current.begin(), current.end(), landmark) > 0;
    if (is_taken || (seen[at].id && *seen[at].id != map[landmark].id)) continue;
    current[at] = landmark;
    try_all(prior, map, seen, clutter, current, at + 1, best, best_set);
    current[at].reset();
  }
}

TEST(JointAssociation, AgreesWithTryingEverySet) {
  Rng rng(5);
  int with_clutter = 0;
  for (int trial = 0; trial < 60; ++trial) {
    // Landmarks so near to one another that each by itself may be of several.
    std::vector<MappedLandmark> landmarks;
    for (int i = 0; i < 6; ++i) {
      landmarks.push_back({i, {rng.uniform(3.0, 6.0), rng.uniform(-1.0, 1.0)}});
    }
    const LandmarkMap map(landmarks);
    const Pose2 truth{};
    auto seen = seen_from(truth, map, {0, 2, 4}, false, rng);
    if (trial % 2 == 0)
      seen[1] = observed(rng.uniform(2.0, 6.0), rng.uniform(-0.3, 0.3), 0.02, 0.004);
    if (trial % 3 == 0) seen[0].id = 0;
    const PoseWithCovariance2 prior =
        about({rng.normal(0.0, 0.15), rng.normal(0.0, 0.15), rng.normal(0.0, 0.005)}, 0.15, 0.005);
    // No gate, as the twin has none: it forbids nothing that clutter would not beat.
    const ClutterModel clutter{.share = 0.05, .max_range_m = 10.0, .gate_chi2 = 1e6};
    const JointAssociation joint = associate_jointly(prior, map, seen, clutter);
    double best = -std::numeric_limits<double>::infinity();
    LandmarkAssociation current(seen.size());
    LandmarkAssociation best_set(seen.size());
    try_all(prior, map, seen, clutter, current, 0, best, best_set);
    EXPECT_TRUE(joint.complete);
    // The twin is of first order about the prior, the search about the pose so far: both agree but
    // for what the heading bends.
    EXPECT_NEAR(joint.log_probability, best, 0.1 + 0.02 * std::abs(best)) << "trial " << trial;
    EXPECT_GT(joint_density(prior, map, seen, joint.landmarks, clutter), best - 0.5)
        << "trial " << trial;
    with_clutter += std::count(best_set.begin(), best_set.end(), std::nullopt) > 0 ? 1 : 0;
  }
  EXPECT_GT(with_clutter, 5);
}

TEST(JointAssociation, WhatOneByOneGetsWrongTogetherIsRight) {
  // A row of landmarks 0.5 m apart, and a prior that is off by nearly that: each observation alone
  // is nearest to its neighbour's landmark. The last one, far off to the side, tells the shift.
  std::vector<MappedLandmark> landmarks;
  for (int i = 0; i < 6; ++i) landmarks.push_back({i, {5.0, 0.5 * i}});
  landmarks.push_back({6, {0.0, 8.0}});
  const LandmarkMap map(landmarks);
  Rng rng(6);
  const auto seen = seen_from({}, map, {1, 2, 3, 6}, false, rng);
  const PoseWithCovariance2 prior = about({0.0, -0.4, 0.0}, 0.4, 0.005);
  const JointAssociation joint = associate_jointly(prior, map, seen, {});
  EXPECT_EQ(joint.landmarks, (LandmarkAssociation{1, 2, 3, 6}));
}

TEST(JointAssociation, AWidePriorIsNoObstacle) {
  const LandmarkMap map = hall_map();
  Rng rng(7);
  for (int trial = 0; trial < 40; ++trial) {
    const Pose2 truth{rng.uniform(-3.0, 3.0), rng.uniform(-3.0, 3.0), rng.uniform(-kPi, kPi)};
    const auto seen = seen_from(truth, map, {0, 2, 5, 6, 9}, false, rng);
    const PoseWithCovariance2 prior =
        about({truth.x + rng.normal(0.0, 0.5), truth.y + rng.normal(0.0, 0.5),
               wrap_angle(truth.yaw + rng.normal(0.0, 0.26))},
              0.5, 0.26);
    const JointAssociation joint = associate_jointly(prior, map, seen, {});
    EXPECT_EQ(joint.landmarks, (LandmarkAssociation{0, 2, 5, 6, 9})) << "trial " << trial;
  }
}

TEST(JointAssociation, AnIdIsOfItsLandmarkOrOfNone) {
  const LandmarkMap map = hall_map();
  Rng rng(8);
  auto seen = seen_from({}, map, {0, 3}, true, rng);
  EXPECT_EQ(associate_jointly(about({}, 0.1, 0.02), map, seen, {}).landmarks,
            (LandmarkAssociation{0, 3}));
  seen[0].id = 5;     // that one is elsewhere
  seen[1].id = 4711;  // nobody knows it
  EXPECT_EQ(associate_jointly(about({}, 0.1, 0.02), map, seen, {}).landmarks,
            (LandmarkAssociation{std::nullopt, std::nullopt}));
}

TEST(JointAssociation, ASearchCutShortSaysSoAndHasAnAnswer) {
  std::vector<MappedLandmark> landmarks;
  for (int i = 0; i < 30; ++i) landmarks.push_back({i, {5.0, 0.05 * i}});
  const LandmarkMap map(landmarks);
  Rng rng(9);
  const auto seen = seen_from({}, map, {3, 7, 11, 15, 19, 23}, false, rng);
  const JointAssociation joint = associate_jointly(about({}, 0.5, 0.1), map, seen, {}, 20);
  EXPECT_FALSE(joint.complete);
  ASSERT_EQ(joint.landmarks.size(), seen.size());
  EXPECT_TRUE(std::isfinite(joint.log_probability));
}

TEST(JointAssociation, NothingSeenIsCertain) {
  const JointAssociation joint = associate_jointly(about({}, 0.5, 0.1), hall_map(), {}, {});
  EXPECT_TRUE(joint.landmarks.empty());
  EXPECT_EQ(joint.log_probability, 0.0);
}

}  // namespace
}  // namespace loopstone
