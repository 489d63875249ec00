#include "loopstone/slam/loose_parts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/rigid_alignment.hpp"

namespace loopstone {
namespace {

constexpr double kStepSigma = 0.02;

/// A path of steps of 1 m, straight on, each as uncertain as the last.
PoseGraph path(int nodes) {
  PoseGraph graph;
  const Eigen::Matrix3d information =
      Eigen::Vector3d(1.0, 1.0, 1e6).asDiagonal() * (1.0 / (kStepSigma * kStepSigma));
  for (int i = 0; i < nodes; ++i) {
    graph.poses.push_back({static_cast<double>(i), 0.0, 0.0});
    if (i > 0)
      graph.edges.push_back(
          {NodeId{i - 1}, NodeId{i}, Pose2{1.0, 0.0, 0.0}, information, EdgeKind::kOdometry});
  }
  return graph;
}

void close(PoseGraph& graph, int from, int to) {
  graph.edges.push_back({NodeId{from}, NodeId{to}, Pose2{static_cast<double>(to - from), 0.0, 0.0},
                         Eigen::Matrix3d::Identity() * 1e4, EdgeKind::kLoopClosure});
}

std::vector<Stamp> stamps_of(const PoseGraph& graph) {
  std::vector<Stamp> stamps;
  for (std::size_t i = 0; i < graph.poses.size(); ++i)
    stamps.push_back(Stamp::from_seconds(static_cast<double>(i)));
  return stamps;
}

GraphTies ties_of(const PoseGraph& graph, std::vector<VisitTie> agreeing = {}, int loops = 0,
                  double reduced_chi2 = 1.0) {
  const std::vector<Stamp> stamps = stamps_of(graph);
  return find_ties_of(
      graph,
      {.stamps = stamps, .agreeing = agreeing, .loops = loops, .reduced_chi2 = reduced_chi2});
}

TEST(LooseParts, WithoutClosuresAllHangsOnThePath) {
  const GraphTies ties = ties_of(path(101));
  ASSERT_EQ(ties.loose.size(), 1U);
  EXPECT_NEAR(ties.loose[0].path_m, 100.0, 1e-9);
  EXPECT_EQ(ties.loose[0].closures, 0);
  EXPECT_NEAR(ties.loose[0].sigma_m, kStepSigma * 10.0, 1e-3) << "a random walk of 100 steps";
  EXPECT_NEAR(ties.loose[0].where.x(), 50.0, 1e-9);
}

TEST(LooseParts, WhatHangsOnOneRecognitionIsLooseAndOnTwoIsNot) {
  PoseGraph graph = path(101);
  close(graph, 10, 60);
  close(graph, 11, 61);  // the same place, recognised again at once
  EXPECT_EQ(ties_of(graph).loose.size(), 1U) << "right or wrong together";
  close(graph, 20, 80);
  const GraphTies ties = ties_of(graph);
  ASSERT_EQ(ties.loose.size(), 2U);
  // Both sides of where two lead across: from 20 to 61.
  EXPECT_NEAR(ties.loose[0].path_m, 39.0, 1e-9);
  EXPECT_EQ(ties.loose[0].from, Stamp::from_seconds(61.0));
  EXPECT_EQ(ties.loose[0].to, Stamp::from_seconds(100.0));
  EXPECT_NEAR(ties.loose[1].path_m, 20.0, 1e-9);
}

TEST(LooseParts, VisitsThatAgreeTieLikeClosures) {
  const PoseGraph graph = path(101);
  const auto at = [](double seconds) { return Stamp::from_seconds(seconds); };
  const GraphTies ties = ties_of(graph, {{at(0.0), at(96.0)}, {at(4.0), at(100.0)}});
  ASSERT_EQ(ties.loose.size(), 2U);
  EXPECT_NEAR(ties.loose[0].path_m, 4.0, 1e-9);
  EXPECT_NEAR(ties.loose[1].path_m, 4.0, 1e-9);
}

TEST(LooseParts, CovariancesAreScaledToWhatLoopsShow) {
  const double promised_m = ties_of(path(101)).loose[0].sigma_m;
  EXPECT_NEAR(ties_of(path(101), {}, 10, 4.0).loose[0].sigma_m, 2.0 * promised_m, 1e-9);
  EXPECT_NEAR(ties_of(path(101), {}, 10, 0.25).loose[0].sigma_m, 0.5 * promised_m, 1e-9);
  EXPECT_NEAR(ties_of(path(101), {}, 1, 4.0).loose[0].sigma_m, promised_m, 1e-9)
      << "a single loop may close by chance";
}

TEST(OpenStretches, AreWhereEdgesAreOpenAlongOneDirectionAndShrinkWithClosures) {
  PoseGraph graph = path(101);
  const double along_m = 0.1;
  for (int i = 30; i < 60; ++i)
    graph.edges[static_cast<std::size_t>(i)].information(0, 0) = 1.0 / (along_m * along_m);
  const GraphTies open = ties_of(graph);
  ASSERT_EQ(open.open.size(), 1U);
  EXPECT_NEAR(open.open[0].path_m, 30.0, 1e-9);
  EXPECT_EQ(open.open[0].from, Stamp::from_seconds(30.0));
  EXPECT_NEAR(open.open[0].sigma_m, along_m * std::sqrt(30.0), 1e-3);
  close(graph, 30, 60);
  EXPECT_EQ(ties_of(graph).open[0].sigma_m, open.open[0].sigma_m)
      << "both visits of a corridor are as long as odometry says";
  EXPECT_TRUE(ties_of(path(101)).open.empty());
}

GraphTies ties_of(const PoseGraph& graph, const std::vector<StepDrift>& drifts,
                  double scale_sigma = 0.0, int loops = 0, double reduced_chi2 = 1.0) {
  const std::vector<Stamp> stamps = stamps_of(graph);
  return find_ties_of(graph, {.stamps = stamps,
                              .drifts = drifts,
                              .scale_sigma = scale_sigma,
                              .loops = loops,
                              .reduced_chi2 = reduced_chi2});
}

TEST(LooseParts, ThePathDriftsByWhatItsStepsSay) {
  const PoseGraph graph = path(101);
  const std::vector<StepDrift> drifts(
      100, {.covariance = 1e-4 * Eigen::Vector3d(1.0, 1.0, 0.0).asDiagonal().toDenseMatrix()});
  const auto ties = [&](int loops, double chi2) {
    return ties_of(graph, drifts, 0.0, loops, chi2);
  };
  EXPECT_NEAR(ties(0, 1.0).loose.at(0).sigma_m, 0.1, 1e-9);
  EXPECT_NEAR(ties(9, 4.0).loose.at(0).sigma_m, 0.2, 1e-9);
  EXPECT_NEAR(ties(9, 0.1).loose.at(0).sigma_m, 0.1, 1e-9) << "drift is no noise of edges";
  EXPECT_TRUE(ties_of(graph, std::vector<StepDrift>(7)).loose.empty());
}

TEST(LooseParts, AnOpenStretchIsAsLongAsOdometrysScaleSays) {
  PoseGraph graph = path(101);
  std::vector<StepDrift> drifts(
      100, {.covariance = 1e-4 * Eigen::Vector3d(1.0, 1.0, 1.0).asDiagonal().toDenseMatrix()});
  for (std::size_t i = 20; i < 60; ++i) drifts[i].open = true;
  const auto ties = [&] { return ties_of(graph, drifts, 0.01); };
  ASSERT_EQ(ties().open.size(), 1U);
  EXPECT_NEAR(ties().open[0].path_m, 40.0, 1e-9);
  EXPECT_NEAR(ties().open[0].sigma_m, std::hypot(0.01 * std::sqrt(40.0), 0.01 * 40.0), 1e-9);
  // Something held the robot back: odometry says 20 cm more.
  drifts[30].off = {-0.2, 0.3};
  EXPECT_NEAR(ties().open[0].sigma_m, std::sqrt(1e-4 * 40.0 + 0.16 + 0.01), 1e-9);
  // Round a corner another stretch begins.
  for (std::size_t i = 40; i < graph.poses.size(); ++i)
    graph.poses[i] = graph.poses[39] * Pose2{0.0, static_cast<double>(i - 39), kPi / 2};
  EXPECT_EQ(ties().open.size(), 2U);
}

/// Drifts that turn and shift, and a path with a bend.
std::pair<PoseGraph, std::vector<StepDrift>> bent_path() {
  PoseGraph graph = path(81);
  for (std::size_t i = 41; i < graph.poses.size(); ++i)
    graph.poses[i] =
        graph.poses[40] * Pose2{0.0, 0.0, kPi / 2} * Pose2{static_cast<double>(i - 40), 0.0, 0.0};
  Eigen::Matrix3d drift = Eigen::Vector3d(4e-5, 1e-5, 4e-7).asDiagonal().toDenseMatrix();
  drift(1, 2) = drift(2, 1) = 1e-6;
  return {graph, std::vector<StepDrift>(80, {.covariance = drift})};
}

/// The naive twin: whole paths with errors drawn step by step, laid onto the true one.
PossibleError drawn(const PoseGraph& graph, const std::vector<StepDrift>& drifts, int draws) {
  Rng rng(7);
  std::vector<double> metres;
  std::vector<double> radians;
  for (int k = 0; k < draws; ++k) {
    std::vector<Pose2> wrong{graph.poses.front()};
    for (std::size_t i = 0; i < drifts.size(); ++i) {
      const Eigen::Matrix3d root = drifts[i].covariance.llt().matrixL();
      const Eigen::Vector3d lost = root * Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal());
      wrong.push_back(wrong.back() * (graph.poses[i].inverse() * graph.poses[i + 1]) *
                      Pose2{lost.x(), lost.y(), lost.z()});
    }
    std::vector<Eigen::Vector2d> source;
    std::vector<Eigen::Vector2d> target;
    for (std::size_t i = 1; i < wrong.size(); ++i) {
      source.push_back(wrong[i].translation());
      target.push_back(graph.poses[i].translation());
    }
    const auto alignment = align_rigidly<2>(source, target);
    const double turn = std::atan2(alignment.rotation(1, 0), alignment.rotation(0, 0));
    double most_m = 0.0;
    double most_rad = 0.0;
    for (std::size_t i = 0; i < source.size(); ++i) {
      const Eigen::Vector2d moved = alignment.rotation * source[i] + alignment.translation;
      most_m = std::max(most_m, (moved - target[i]).norm());
      most_rad = std::max(most_rad,
                          std::abs(wrap_angle(wrong[i + 1].yaw + turn - graph.poses[i + 1].yaw)));
    }
    metres.push_back(most_m);
    radians.push_back(most_rad);
  }
  std::ranges::sort(metres);
  std::ranges::sort(radians);
  const auto at = static_cast<std::size_t>(0.975 * (draws - 1));
  return {metres[at], radians[at]};
}

TEST(Contradictions, CanBeNoFurtherOffThanThePathBetweenTheirVisits) {
  PoseGraph graph = path(101);
  const std::vector<StepDrift> drifts(
      100, {.covariance = 1e-4 * Eigen::Vector3d(1.0, 1.0, 0.0).asDiagonal().toDenseMatrix()});
  const auto at = [](double seconds) { return Stamp::from_seconds(seconds); };
  const std::vector<VisitContradiction> regions{{.low = {12.0, 1.0},
                                                 .high = {14.0, 3.0},
                                                 .first_from = at(10.0),
                                                 .first_to = at(12.0),
                                                 .second_from = at(26.0),
                                                 .second_to = at(28.0)}};
  const std::vector<Stamp> stamps = stamps_of(graph);
  const auto off_m = [&] {
    return find_ties_of(graph, {.stamps = stamps, .drifts = drifts, .contradictions = regions})
        .contradictions_m.at(0);
  };
  EXPECT_NEAR(off_m(), 3.0 * 0.01 * std::sqrt(16.0), 1e-9);
  close(graph, 0, 40);
  close(graph, 5, 50);
  EXPECT_NEAR(off_m(), 3.0 * 0.01 * std::sqrt(16.0), 1e-9) << "closures may be wrong";
  // They pulled the path by 1.5 m between the visits.
  for (std::size_t i = 20; i < graph.poses.size(); ++i) graph.poses[i].y += 1.5;
  EXPECT_NEAR(off_m(), 3.0 * 0.01 * std::sqrt(16.0) + 1.5, 1e-9);
}

TEST(PossibleError, IsThatOfPathsThatAreDrawnAtRandom) {
  const auto [graph, drifts] = bent_path();
  const PossibleError said = ties_of(graph, drifts).possible;
  const PossibleError twin = drawn(graph, drifts, 4000);
  EXPECT_NEAR(said.m, twin.m, 0.2 * twin.m);
  EXPECT_NEAR(said.rad, twin.rad, 0.2 * twin.rad);
  EXPECT_GT(said.m, 0.05);
}

TEST(PossibleError, GrowsWithDriftsAndEndsWhereTwoPlacesTie) {
  auto [graph, drifts] = bent_path();
  const auto possible = [&graph = graph, &drifts = drifts] {
    return ties_of(graph, drifts).possible;
  };
  const PossibleError once = possible();
  for (StepDrift& drift : drifts) drift.covariance *= 4.0;
  EXPECT_NEAR(possible().m, 2.0 * once.m, 1e-9);
  EXPECT_NEAR(possible().rad, 2.0 * once.rad, 1e-9);
  close(graph, 0, 79);
  EXPECT_NEAR(possible().m, 2.0 * once.m, 1e-9) << "a single recognition may be wrong";
  close(graph, 5, 80);
  const PossibleError tied = possible();
  EXPECT_LT(tied.m, 0.5 * once.m) << "its ends are still loose";
  EXPECT_GT(tied.m, 0.0);
}

TEST(PossibleError, NoClosureTiesTheLengthOfWhatIsOpen) {
  PoseGraph graph = path(101);
  close(graph, 0, 100);
  close(graph, 0, 96);
  close(graph, 5, 100);
  std::vector<StepDrift> drifts(
      100, {.covariance = 1e-4 * Eigen::Vector3d(1.0, 1.0, 0.0).asDiagonal().toDenseMatrix()});
  const auto possible_m = [&](double scale_sigma) {
    return ties_of(graph, drifts, scale_sigma).possible.m;
  };
  const double closed = possible_m(0.01);
  EXPECT_EQ(closed, possible_m(0.0));
  EXPECT_LT(closed, 0.05);
  for (std::size_t i = 10; i < 90; ++i) drifts[i].open = true;
  EXPECT_GT(possible_m(0.0), closed);
  // 80 m are 1.6 m too long in two standard deviations; half of that, best aligned.
  EXPECT_NEAR(possible_m(0.01), 0.8, 0.3);
  EXPECT_LE(ties_of(graph, drifts, 0.01).possible_beside.m, closed)
      << "but for how long it is, the map is as it was";
}

TEST(PossibleError, BesideOpenWaysIsWhatTheyLoseAcrossAndInHeading) {
  const PoseGraph graph = path(101);
  std::vector<StepDrift> drifts(
      100,
      {.covariance = Eigen::Vector3d(1e-2, 1e-6, 1e-8).asDiagonal().toDenseMatrix(), .open = true});
  const GraphTies ties = ties_of(graph, drifts, 0.05);
  for (StepDrift& drift : drifts) drift = {.covariance = drift.covariance};
  for (StepDrift& drift : drifts) drift.covariance(0, 0) = 0.0;
  const GraphTies across = ties_of(graph, drifts);
  EXPECT_GT(ties.possible.m, 1.0);
  EXPECT_NEAR(ties.possible_beside.m, across.possible.m, 1e-9);
  EXPECT_NEAR(ties.possible_beside.rad, across.possible.rad, 1e-9);
  EXPECT_GT(across.possible.m, 0.001);
}

TEST(LooseParts, NothingIsSaidOfAGraphWithoutAPath) {
  EXPECT_TRUE(ties_of(PoseGraph{}).loose.empty());
  PoseGraph torn = path(10);
  torn.edges.erase(torn.edges.begin() + 4);
  EXPECT_TRUE(ties_of(torn).loose.empty());
}

}  // namespace
}  // namespace loopstone
