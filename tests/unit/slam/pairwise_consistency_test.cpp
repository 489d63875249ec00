#include "slam/pairwise_consistency.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

constexpr int kSteps = 200;
constexpr double kStepM = 0.5;
constexpr std::size_t kStepsPerSubmap = 4;

/// Twice around a circle of 50 m; the map has every step turned a bit too far, so the second lap
/// lies off the first. Submaps begin at steps 2, 6, 10 ..., and closures are named by these.
struct Laps {
  std::vector<Pose2> truth{Pose2{}};
  std::vector<Pose2> poses{Pose2{}};
  std::vector<double> travelled_m{0.0};

  Laps() {
    for (int i = 0; i < kSteps; ++i) {
      truth.push_back(truth.back() * exp(Tangent2(kStepM, 0.0, 4.0 * kPi / kSteps)));
      poses.push_back(poses.back() * exp(Tangent2(kStepM, 0.0, 4.0 * kPi / kSteps + 0.001)));
      travelled_m.push_back(travelled_m.back() + kStepM);
    }
  }
  [[nodiscard]] std::vector<SubmapRecord> map() const {
    std::vector<SubmapRecord> submaps;
    for (std::size_t step = 2; step < poses.size(); step += kStepsPerSubmap) {
      SubmapRecord& submap = submaps.emplace_back();
      submap.map_T_submap = poses[step];
      submap.travelled_m = travelled_m[step];
    }
    return submaps;
  }

  /// As registration would see it, `off` beside the truth.
  [[nodiscard]] LoopClosure closure(int from, int to, const Pose2& off = {}) const {
    LoopClosure c;
    c.from_submap = {static_cast<std::size_t>(from) / kStepsPerSubmap};
    c.to_submap = {static_cast<std::size_t>(to) / kStepsPerSubmap};
    c.from_T_to =
        truth[static_cast<std::size_t>(from)].inverse() * truth[static_cast<std::size_t>(to)] * off;
    c.covariance = Eigen::Vector3d(1e-3, 1e-3, 3e-5).asDiagonal();
    c.state = ClosureState::kWaiting;
    c.reason = ClosureReason::kWaitsForSecond;
    return c;
  }
};

TEST(PairwiseConsistency, TwoTrueClosuresAreConsistent) {
  const Laps laps;
  const LoopClosure a = laps.closure(10, 110);
  const LoopClosure b = laps.closure(18, 118);
  EXPECT_FALSE(bends_nothing(a, laps.map()));
  EXPECT_TRUE(are_consistent(a, b, laps.map()));
  EXPECT_TRUE(are_consistent(b, a, laps.map()));
}

TEST(PairwiseConsistency, SubmapsThatShareScansCountOnceUnlessBothAreGood) {
  const Laps laps;
  LoopClosure a = laps.closure(10, 110);
  LoopClosure b = laps.closure(10, 114);
  EXPECT_FALSE(are_consistent(a, b, laps.map()));
  EXPECT_FALSE(are_consistent(a, laps.closure(14, 114), laps.map()));
  a.overlap = b.overlap = 0.8;
  a.agreement = b.agreement = 0.9;
  EXPECT_TRUE(are_consistent(a, b, laps.map()));
  b.agreement = 0.8;
  EXPECT_FALSE(are_consistent(a, b, laps.map()));
  EXPECT_FALSE(are_consistent(b, a, laps.map()));
  // Another place on one side is enough.
  EXPECT_TRUE(are_consistent(a, laps.closure(10, 118), laps.map()));
  EXPECT_TRUE(are_consistent(a, laps.closure(18, 110), laps.map()));
}

TEST(PairwiseConsistency, AFalseClosureIsNotBackedByATrueOneOrByAnotherFalseOne) {
  const Laps laps;
  const LoopClosure truth = laps.closure(10, 110);
  const LoopClosure next_room = laps.closure(18, 118, {3.0, 0.0, 0.0});
  const LoopClosure other_room = laps.closure(26, 126, {0.0, -2.0, 0.0});
  EXPECT_FALSE(are_consistent(next_room, truth, laps.map()));
  EXPECT_FALSE(are_consistent(truth, next_room, laps.map()));
  EXPECT_FALSE(are_consistent(next_room, other_room, laps.map()));
}

/// The second lap as a drive of its own, which nothing ties to the first: it lies where the truth
/// has it, but for what `map_T_truth` moves it by.
std::vector<SubmapRecord> another_drive(const Laps& laps, const Pose2& map_T_truth) {
  std::vector<SubmapRecord> submaps = laps.map();
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    const Pose2& truth = laps.truth[2 + kStepsPerSubmap * i];
    submaps[i].map_T_submap = i < 25 ? truth : map_T_truth * truth;
    submaps[i].keys.resize(1);
  }
  submaps[25].keys.front().starts_drive = true;
  return submaps;
}

TEST(PairwiseConsistency, HowTwoDrivesThatNothingTiesLieToOneAnotherSaysNothing) {
  const Laps laps;
  const std::vector<LoopClosure> both{laps.closure(10, 110), laps.closure(18, 118)};
  // Far off, but facing nearly as it should: so little of a turn two closures would not notice.
  EXPECT_EQ(consistent_ones(both, another_drive(laps, {100.0, 0.0, 0.045})).size(), 2U);
  EXPECT_EQ(consistent_ones(both, another_drive(laps, {100.0, 0.0, 2.0})).size(), 2U);
  EXPECT_EQ(consistent_ones(both, another_drive(laps, {})).size(), 2U);
}

TEST(PairwiseConsistency, OneClosureTiesNoDriveThoughItBendsNothing) {
  const Laps laps;
  const std::vector<LoopClosure> one{laps.closure(10, 110)};
  EXPECT_TRUE(bends_nothing(one.front(), another_drive(laps, {})));
  EXPECT_TRUE(consistent_ones(one, another_drive(laps, {})).empty());
}

TEST(PairwiseConsistency, FarAwayNothingIsConsistent) {
  const Laps laps;
  EXPECT_FALSE(are_consistent(laps.closure(2, 102), laps.closure(90, 190), laps.map()));
}

TEST(PairwiseConsistency, ACorridorSaysNothingOfTheWayAlongIt) {
  Laps laps;
  const LoopClosure a = laps.closure(10, 110, {2.0, 0.0, 0.0});
  LoopClosure corridor = laps.closure(14, 114);
  corridor.covariance = Eigen::Vector3d(1e3, 1e3, 3e-5).asDiagonal();
  EXPECT_FALSE(are_consistent(a, corridor, laps.map()));
}

TEST(PairwiseConsistency, WhatTheMapSaysAlreadyStandsAlone) {
  Laps laps;
  laps.poses = laps.truth;
  EXPECT_TRUE(bends_nothing(laps.closure(10, 110), laps.map()));
  EXPECT_TRUE(bends_nothing(laps.closure(10, 110, {0.2, 0.0, 0.02}), laps.map()));
  EXPECT_FALSE(bends_nothing(laps.closure(10, 110, {0.6, 0.0, 0.0}), laps.map()));
  EXPECT_FALSE(bends_nothing(laps.closure(10, 110, {0.0, 0.0, 0.2}), laps.map()));
  // Off along a direction that it does not hold, it pulls at nothing.
  LoopClosure open = laps.closure(10, 110, {5.0, 0.0, 0.0});
  const Pose2 now = laps.poses[10].inverse() * laps.poses[110];
  const Eigen::Vector2d along = (open.from_T_to.translation() - now.translation()).normalized();
  open.covariance.topLeftCorner<2, 2>() += 1e3 * along * along.transpose();
  EXPECT_TRUE(bends_nothing(open, laps.map()));
}

using Places = std::vector<std::size_t>;

TEST(PairwiseConsistency, OnlyThoseThatAgreeMayStand) {
  const Laps laps;
  std::vector<LoopClosure> closures{laps.closure(10, 110)};
  EXPECT_EQ(consistent_ones(closures, laps.map()), Places{});
  closures.push_back(laps.closure(30, 130, {4.0, 1.0, 0.0}));
  EXPECT_EQ(consistent_ones(closures, laps.map()), Places{});
  closures.push_back(laps.closure(18, 118));
  EXPECT_EQ(consistent_ones(closures, laps.map()), (Places{0, 2}));
  closures[2].state = ClosureState::kStanding;
  EXPECT_EQ(consistent_ones(closures, laps.map()), Places{0}) << "what stands is a witness";
}

TEST(PairwiseConsistency, WhatWasRejectedForAReasonIsNeitherAcceptedNorHeard) {
  const Laps laps;
  std::vector<LoopClosure> closures{laps.closure(10, 110), laps.closure(18, 118)};
  closures[1].state = ClosureState::kRejected;
  closures[1].reason = ClosureReason::kSurfacesDisagree;
  EXPECT_EQ(consistent_ones(closures, laps.map()), Places{});
}

TEST(PairwiseConsistency, WhatFitsElsewhereTooStandsAloneOnlyWhereTheMapHasIt) {
  Laps laps;
  laps.poses = laps.truth;
  LoopClosure there = laps.closure(10, 110, {0.1, 0.0, 0.0});
  there.second_score = 0.5;
  EXPECT_EQ(consistent_ones(std::vector{there}, laps.map()), Places{0});
  // Elsewhere along a direction that it does not hold: it bends nothing, and says nothing.
  LoopClosure open = laps.closure(10, 110, {5.0, 0.0, 0.0});
  const Pose2 now = laps.poses[10].inverse() * laps.poses[110];
  const Eigen::Vector2d along = (open.from_T_to.translation() - now.translation()).normalized();
  open.covariance.topLeftCorner<2, 2>() += 1e3 * along * along.transpose();
  EXPECT_EQ(consistent_ones(std::vector{open}, laps.map()), Places{0});
  open.second_score = 0.5;
  EXPECT_EQ(consistent_ones(std::vector{open}, laps.map()), Places{});
}

}  // namespace
}  // namespace loopstone
