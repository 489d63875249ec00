#include "loopstone/slam/surface_adjustment.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "slam/surface_patches.hpp"
#include "slam/surface_segments.hpp"
#include "slam/surface_system.hpp"
#include "support/pose_near.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

using test::pose_near;

/// A drive, what was seen on it, and a graph that has every step a bit wrong.
struct Recording {
  std::vector<Pose2> truth;
  std::vector<std::vector<SurfacePoint>> surfaces;
  PoseGraph graph;
};

Recording record(const test::Walls& walls, const std::vector<Pose2>& truth, double error_m,
                 double error_rad, std::uint64_t seed, double noise_m = 0.0) {
  Recording r;
  r.truth = truth;
  Rng rng(seed);
  BeamTable beams;
  test::Scanner scanner;
  scanner.noise_m = noise_m;
  for (const Pose2& pose : truth) {
    const LaserScan scan = test::scan_from(walls, pose, {}, scanner, &rng);
    r.surfaces.push_back(surface_points(scan, {}, Tangent2::Zero(), {.points_max = 120}, beams));
  }
  r.graph.poses.push_back(truth.front());
  const Eigen::Vector3d sigma(error_m, error_m, error_rad);
  const Eigen::Matrix3d information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  for (std::size_t i = 1; i < truth.size(); ++i) {
    const double x = rng.normal();
    const double y = rng.normal();
    const double yaw = rng.normal();
    const Pose2 motion =
        truth[i - 1].inverse() * truth[i] * Pose2{error_m * x, error_m * y, error_rad * yaw};
    r.graph.poses.push_back(r.graph.poses.back() * motion);
    r.graph.edges.push_back({NodeId{static_cast<int>(i) - 1}, NodeId{static_cast<int>(i)}, motion,
                             information, EdgeKind::kOdometry});
  }
  return r;
}

std::vector<Pose2> round_of_the_room() {
  return test::drive_through({{1.5, 1.2}, {5.0, 1.5}, {5.2, 3.6}, {3.4, 4.4}, {1.5, 1.2}}, 0.4,
                             0.5);
}

double largest_error_m(const std::vector<Pose2>& poses, const std::vector<Pose2>& truth) {
  double largest = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    largest = std::max(largest, (poses[i].translation() - truth[i].translation()).norm());
  }
  return largest;
}

std::vector<int> places_after_first(std::size_t count) {
  std::vector<int> places{-1};
  for (std::size_t i = 1; i < count; ++i) places.push_back(static_cast<int>(i) - 1);
  return places;
}

using Blocks = std::vector<Eigen::Vector3d>;

Eigen::VectorXd stacked(const Blocks& blocks) {
  Eigen::VectorXd v(3 * static_cast<Eigen::Index>(blocks.size()));
  for (std::size_t i = 0; i < blocks.size(); ++i)
    v.segment<3>(3 * static_cast<Eigen::Index>(i)) = blocks[i];
  return v;
}

Blocks random_blocks(std::size_t count, Rng& rng) {
  Blocks blocks(count);
  for (auto& block : blocks) {
    for (int k = 0; k < 3; ++k) block[k] = rng.normal();
  }
  return blocks;
}

/// The matrix that multiply_add multiplies with, column by column.
Eigen::MatrixXd dense(SurfaceSystem& system, std::size_t count) {
  const auto size = 3 * static_cast<Eigen::Index>(count);
  Eigen::MatrixXd m(size, size);
  for (Eigen::Index column = 0; column < size; ++column) {
    Blocks x(count, Eigen::Vector3d::Zero());
    Blocks y = x;
    x[static_cast<std::size_t>(column / 3)][column % 3] = 1.0;
    system.multiply_add(x, y);
    m.col(column) = stacked(y);
  }
  return m;
}

TEST(SurfaceAdjustment, BringsPosesBackToWhereTheWallsSayTheyAre) {
  const auto truth = round_of_the_room();
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Recording r = record(test::furnished_room(), truth, 0.006, 0.002, seed, 0.01);
    const double before = largest_error_m(r.graph.poses, truth);
    const auto adjusted = adjust_to_surfaces(r.graph, r.surfaces);
    EXPECT_GT(before, 0.02);
    EXPECT_LT(largest_error_m(adjusted.poses, truth), 0.006) << "before: " << before;
    EXPECT_LT(adjusted.spread_after_m, 0.5 * adjusted.spread_before_m);
    EXPECT_EQ(adjusted.poses.front(), truth.front());
  }
}

TEST(SurfaceAdjustment, LeavesAloneWhatIsRight) {
  const auto truth = round_of_the_room();
  Recording r = record(test::furnished_room(), truth, 1e-9, 1e-9, 1);
  const auto adjusted = adjust_to_surfaces(r.graph, r.surfaces);
  EXPECT_LT(largest_error_m(adjusted.poses, truth), 0.002);
}

TEST(SurfaceAdjustment, TheGraphHoldsACorridorsAxis) {
  // Walls without an end in sight say nothing about the way along them.
  const test::Walls corridor{{{-60.0, 0.0}, {80.0, 0.0}}, {{-60.0, 2.0}, {80.0, 2.0}}};
  const auto truth = test::drive_through({{0.0, 0.9}, {12.0, 1.1}}, 0.4, 0.5);
  const Recording r = record(corridor, truth, 0.005, 0.002, 4);
  const auto adjusted = adjust_to_surfaces(r.graph, r.surfaces);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_NEAR(adjusted.poses[i].x, r.graph.poses[i].x, 0.01);
    EXPECT_NEAR(adjusted.poses[i].y, truth[i].y, 0.003);
    EXPECT_NEAR(adjusted.poses[i].yaw, truth[i].yaw, 0.002);
  }
}

TEST(SurfaceAdjustment, NoiseOfNormalsPullsNobodyAlongACorridor) {
  const test::Walls corridor{{{-60.0, 0.0}, {80.0, 0.0}}, {{-60.0, 2.0}, {80.0, 2.0}}};
  const auto truth = test::drive_through({{0.0, 0.9}, {24.0, 1.1}, {1.0, 1.0}}, 0.4, 0.5);
  const Recording r = record(corridor, truth, 0.003, 0.001, 4, 0.02);
  const auto adjusted = adjust_to_surfaces(r.graph, r.surfaces);
  ASSERT_GT(adjusted.rounds, 0);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_NEAR(adjusted.poses[i].x, r.graph.poses[i].x, 0.006);
    EXPECT_NEAR(adjusted.poses[i].y, truth[i].y, 0.02);
  }
}

TEST(SurfaceAdjustment, GoesAlongWithACommonMotion) {
  const Recording r = record(test::furnished_room(), round_of_the_room(), 0.004, 0.001, 5, 0.005);
  const Pose2 motion{13.0, -7.0, 0.9};
  PoseGraph moved = r.graph;
  for (Pose2& pose : moved.poses) pose = motion * pose;
  const auto here = adjust_to_surfaces(r.graph, r.surfaces);
  const auto there = adjust_to_surfaces(moved, r.surfaces);
  // The cells fall otherwise, so only nearly.
  for (std::size_t i = 0; i < here.poses.size(); ++i) {
    EXPECT_TRUE(pose_near(there.poses[i], motion * here.poses[i], 0.004, 0.002));
  }
}

TEST(SurfaceAdjustment, IsTheSameForAnyNumberOfThreads) {
  const Recording r = record(test::furnished_room(), round_of_the_room(), 0.005, 0.002, 6, 0.01);
  const auto one = adjust_to_surfaces(r.graph, r.surfaces, {}, {1});
  const auto four = adjust_to_surfaces(r.graph, r.surfaces, {}, {4});
  EXPECT_EQ(one.poses, four.poses);
  EXPECT_EQ(one.spread_after_m, four.spread_after_m);
}

TEST(SurfaceAdjustment, NothingSeenChangesNothing) {
  Recording r = record(test::furnished_room(), round_of_the_room(), 0.005, 0.002, 7);
  for (auto& surfaces : r.surfaces) surfaces.clear();
  EXPECT_EQ(adjust_to_surfaces(r.graph, r.surfaces).poses, r.graph.poses);
  const std::vector<std::vector<SurfacePoint>> one(1);
  EXPECT_EQ(adjust_to_surfaces({.poses = {Pose2{1.0, 2.0, 0.5}}}, one).poses.size(), 1U);
}

TEST(SurfaceAdjustment, WantsAScanForEachPose) {
  Recording r = record(test::furnished_room(), round_of_the_room(), 0.005, 0.002, 8);
  r.surfaces.pop_back();
  EXPECT_THROW((void)adjust_to_surfaces(r.graph, r.surfaces), UsageError);
}

TEST(SurfacePatches, AreSharedAndHoldEverySightOnce) {
  const Recording r = record(test::furnished_room(), round_of_the_room(), 0.003, 0.001, 9);
  const auto keys = placed(r.graph.poses);
  const SurfacePatches patches = find_patches(keys, r.surfaces, 0.2);
  ASSERT_FALSE(patches.patches.empty());
  std::size_t end = 0;
  for (const SharedSurface& patch : patches.patches) {
    EXPECT_EQ(patch.first, end);
    end = patch.last;
    EXPECT_NEAR(patch.normal.norm(), 1.0, 1e-12);
    EXPECT_NE(patches.sights[patch.first].key, patches.sights[patch.last - 1].key);
    for (std::size_t i = patch.first; i < patch.last; ++i) {
      const PatchSight& sight = patches.sights[i];
      const Eigen::Vector2d at = keys[static_cast<std::size_t>(sight.key)] * sight.point;
      EXPECT_LT((at - patch.centre).norm(), 0.3);
      if (i == patch.first) continue;
      EXPECT_LE(patches.sights[i - 1].key, sight.key);
    }
  }
  EXPECT_EQ(end, patches.sights.size());
}

TEST(SurfaceSystem, EliminatesEachPatchAsTheDenseSchurComplementDoes) {
  const Recording r = record(test::furnished_room(), round_of_the_room(), 0.003, 0.001, 10, 0.01);
  const std::size_t count = r.truth.size() - 1;
  const auto places = places_after_first(r.truth.size());
  const auto keys = placed(r.graph.poses);
  const SurfacePatches patches = find_patches(keys, r.surfaces, 0.3);
  SurfaceSystem system(patches, places, count, {1});
  (void)system.linearise(keys, 0.02);

  const auto size = 3 * static_cast<Eigen::Index>(count);
  Eigen::MatrixXd naive = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t p = 0; p < patches.patches.size(); ++p) {
    const SharedSurface& patch = patches.patches[p];
    const auto sights = static_cast<Eigen::Index>(patch.last - patch.first);
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(sights, size);
    Eigen::MatrixXd lines(sights, 2);
    Eigen::VectorXd weights(sights);
    for (Eigen::Index i = 0; i < sights; ++i) {
      const auto& row = system.rows()[patch.first + static_cast<std::size_t>(i)];
      if (row.place >= 0) {
        jacobian.block<1, 3>(i, 3 * row.place) << patch.normal.x(), patch.normal.y(), row.turn;
      }
      lines.row(i) << 1.0, row.along;
      weights[i] = row.weight;
    }
    Eigen::Matrix2d c = lines.transpose() * weights.asDiagonal() * lines;
    c(1, 1) += 100.0;  // the slope is known to 0.1
    const Eigen::MatrixXd b = jacobian.transpose() * weights.asDiagonal() * lines;
    naive +=
        jacobian.transpose() * weights.asDiagonal() * jacobian - b * c.inverse() * b.transpose();
  }
  const Eigen::MatrixXd found = dense(system, count);
  EXPECT_LT((found - naive).norm(), 1e-6 * naive.norm());
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    EXPECT_LT((system.diagonal()[i] - naive.block<3, 3>(at, at)).norm(), 1e-5 * naive.norm());
  }
}

TEST(SurfaceSystem, SaysNothingOfAScanThatACorridorLeavesOpen) {
  const test::Walls corridor{{{-60.0, 0.0}, {80.0, 0.0}}, {{-60.0, 2.0}, {80.0, 2.0}}};
  const auto truth = test::drive_through({{0.0, 0.9}, {12.0, 1.1}}, 0.4, 0.5);
  const Recording r = record(corridor, truth, 0.001, 0.0005, 13, 0.02);
  const std::size_t count = truth.size() - 1;
  const auto places = places_after_first(truth.size());
  const auto keys = placed(truth);
  const SurfacePatches patches = find_patches(keys, r.surfaces, 0.3);
  SurfaceSystem system(patches, places, count, {1});
  (void)system.linearise(keys, 0.02);
  const Eigen::MatrixXd found = dense(system, count);
  for (std::size_t key = 0; key < count; ++key) {
    const auto at = 3 * static_cast<Eigen::Index>(key);
    const Eigen::Matrix3d own = found.block<3, 3>(at, at);
    EXPECT_GT(own(1, 1), 1e3) << key;  // across
    // The open motion turns with the corridor: in the basis of the block it has no information.
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(own);
    EXPECT_LT(axes.eigenvalues()(0), 1e-6 * axes.eigenvalues()(2)) << key;
    EXPECT_GT(std::abs(axes.eigenvectors()(0, 0)), 0.9) << key;
  }
}

TEST(SurfaceSystem, TheGradientIsThatOfTheCost) {
  const Recording r = record(test::furnished_room(), round_of_the_room(), 0.003, 0.001, 11, 0.01);
  const std::size_t count = r.truth.size() - 1;
  const auto places = places_after_first(r.truth.size());
  const SurfacePatches patches = find_patches(placed(r.graph.poses), r.surfaces, 0.3);
  // Far wider than any distance, the kernel is a parabola; then weights do not depend on the poses.
  constexpr double kSigmaM = 5.0;
  SurfaceSystem system(patches, places, count, {1});
  (void)system.linearise(placed(r.graph.poses), kSigmaM);
  const Blocks gradient = system.gradient();
  double scale = 0.0;
  for (const auto& g : gradient) scale = std::max(scale, g.norm());
  for (std::size_t key = 1; key <= count; key += 5) {
    for (int k = 0; k < 3; ++k) {
      constexpr double kStep = 1e-3;
      double costs[2];
      for (int side = 0; side < 2; ++side) {
        auto poses = r.graph.poses;
        const double step = side == 0 ? -kStep : kStep;
        Pose2& pose = poses[key];
        (k == 0 ? pose.x : k == 1 ? pose.y : pose.yaw) += step;
        SurfaceSystem other(patches, places, count, {1});
        costs[side] = other.linearise(placed(poses), kSigmaM);
      }
      // The cost has no factor of one half.
      const double numeric = (costs[1] - costs[0]) / (4.0 * kStep);
      EXPECT_NEAR(gradient[key - 1][k], numeric, 0.03 * scale);
    }
  }
}

TEST(SurfaceSegments, SolveForRigidStretchesAsTheDenseProjectionDoes) {
  const Recording r = record(test::furnished_room(), round_of_the_room(), 0.003, 0.001, 12, 0.01);
  const std::size_t count = r.truth.size() - 1;
  const auto places = places_after_first(r.truth.size());
  const auto keys = placed(r.graph.poses);
  const SurfacePatches patches = find_patches(keys, r.surfaces, 0.3);
  SurfaceSystem system(patches, places, count, {1});
  (void)system.linearise(keys, 0.02);
  // A graph of the simplest kind: unit blocks, each pose tied to the next.
  std::vector<std::pair<int, int>> chain;
  for (std::size_t i = 1; i < count; ++i)
    chain.emplace_back(static_cast<int>(i) - 1, static_cast<int>(i));
  BlockMatrix graph = block_matrix(static_cast<int>(count), chain);
  for (auto& block : graph.diagonal) block = 50.0 * Eigen::Matrix3d::Identity();
  for (auto& block : graph.below) block = -20.0 * Eigen::Matrix3d::Identity();
  SurfaceSegments segments(r.graph.poses, places, r.graph.poses.size() - 1);
  ASSERT_TRUE(segments.factorise(system, graph));

  Eigen::MatrixXd whole = dense(system, count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    whole.block<3, 3>(at, at) += graph.diagonal[i];
    if (i + 1 == count) continue;
    whole.block<3, 3>(at + 3, at) += graph.below[i];
    whole.block<3, 3>(at, at + 3) += graph.below[i].transpose();
  }
  constexpr std::size_t kKeys = 12;
  const std::size_t stretches = (count + kKeys - 1) / kKeys;
  Eigen::MatrixXd p = Eigen::MatrixXd::Zero(whole.rows(), 3 * static_cast<Eigen::Index>(stretches));
  for (std::size_t i = 0; i < count; ++i) {
    // About any point: the span is the same.
    const Eigen::Vector2d at = r.graph.poses[i + 1].translation();
    Eigen::Matrix3d motion = Eigen::Matrix3d::Identity();
    motion(0, 2) = -at.y();
    motion(1, 2) = at.x();
    p.block<3, 3>(3 * static_cast<Eigen::Index>(i), 3 * static_cast<Eigen::Index>(i / kKeys)) =
        motion;
  }
  Rng rng(3);
  const Blocks right = random_blocks(count, rng);
  Blocks found(count, Eigen::Vector3d::Zero());
  segments.add_correction(right, found);
  const Eigen::VectorXd expected =
      p * (p.transpose() * whole * p).ldlt().solve(p.transpose() * stacked(right));
  EXPECT_LT((stacked(found) - expected).norm(), 1e-5 * expected.norm());
}

/// The room is seen on both sides of a break; only a closure tells that it is the same one.
TEST(SurfaceAdjustment, AcrossABreakThatNothingTiesSurfacesKnowNothing) {
  const Recording drive =
      record(test::furnished_room(), round_of_the_room(), 0.002, 0.0005, 5, 0.005);
  const int last = static_cast<int>(drive.truth.size()) - 1;
  const int first_after = last / 2;
  PoseGraph broken = drive.graph;
  const Eigen::Vector3d lost(0.5, 0.5, 0.3);
  broken.edges[static_cast<std::size_t>(first_after) - 1].information =
      lost.cwiseAbs2().cwiseInverse().asDiagonal();
  PoseGraph closed = broken;
  const Eigen::Vector3d sigma(0.03, 0.03, 0.005);
  closed.edges.push_back({NodeId{1}, NodeId{last}, closed.poses[1].inverse() * closed.poses.back(),
                          sigma.cwiseAbs2().cwiseInverse().asDiagonal(), EdgeKind::kLoopClosure});
  const auto sigma_across = [&](const PoseGraph& graph, bool is_told) {
    PathWeakness weakness;
    weakness.broken.resize(drive.truth.size(), false);
    weakness.broken[static_cast<std::size_t>(first_after)] = is_told;
    const SurfaceAdjustment adjusted = adjust_to_surfaces(graph, drive.surfaces, {}, {}, weakness);
    const Eigen::Matrix3d covariance =
        adjusted.covariances.between(NodeId{first_after - 1}, NodeId{first_after});
    return std::sqrt(std::min(covariance(0, 0), covariance(1, 1)));
  };
  EXPECT_GT(sigma_across(broken, true), 0.4);
  EXPECT_LT(sigma_across(broken, false), 0.1) << "the laser followed it";
  EXPECT_LT(sigma_across(closed, true), 0.1) << "it is the same room";
}

}  // namespace
}  // namespace loopstone
