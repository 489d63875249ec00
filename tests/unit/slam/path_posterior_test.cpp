#include "slam/path_posterior.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "loopstone/slam/loose_parts.hpp"
#include "loopstone/slam/surface_adjustment.hpp"
#include "slam/open_directions.hpp"
#include "slam/surface_adjustment_numbers.hpp"
#include "slam/surface_patches.hpp"
#include "slam/surface_system.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

constexpr double kStepM = 0.01;
constexpr double kStepRad = 0.005;

/// A drive, what was seen on it with some noise, and the graph of its steps.
struct Drive {
  std::vector<Pose2> poses;
  std::vector<std::vector<SurfacePoint>> surfaces;
  PoseGraph graph;
};

Drive drive(const test::Walls& walls, const std::vector<Eigen::Vector2d>& through) {
  Drive d{.poses = test::drive_through(through, 0.3, 0.3)};
  Rng rng(5);
  BeamTable beams;
  test::Scanner scanner;
  scanner.noise_m = 0.01;
  const Eigen::Vector3d sigma(kStepM, kStepM, kStepRad);
  const Eigen::Matrix3d information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  for (const Pose2& pose : d.poses) {
    const LaserScan scan = test::scan_from(walls, pose, {}, scanner, &rng);
    d.surfaces.push_back(surface_points(scan, {}, Tangent2::Zero(), {.points_max = 120}, beams));
    d.graph.poses.push_back(pose);
    const auto i = static_cast<int>(d.graph.poses.size()) - 1;
    if (i == 0) continue;
    const Pose2 motion = d.poses[static_cast<std::size_t>(i) - 1].inverse() * pose;
    d.graph.edges.push_back({NodeId{i - 1}, NodeId{i}, motion, information, EdgeKind::kOdometry});
  }
  return d;
}

/// Twice round the room, so that all is seen again.
Drive twice_round_the_room() {
  return drive(test::furnished_room(), {{1.5, 1.2},
                                        {5.0, 1.5},
                                        {5.2, 3.6},
                                        {3.4, 4.4},
                                        {1.5, 1.2},
                                        {5.0, 1.5},
                                        {5.2, 3.6},
                                        {3.4, 4.4},
                                        {1.5, 1.2}});
}

/// Bare walls on both sides, out of sight at both ends.
Drive down_a_corridor() {
  const test::Walls walls{{{-60.0, -1.0}, {80.0, -1.0}}, {{-60.0, 1.2}, {80.0, 1.2}}};
  return drive(walls, {{0.0, 0.0}, {18.0, 0.0}});
}

std::vector<int> all_in_place(std::size_t count) {
  std::vector<int> places;
  for (std::size_t i = 0; i < count; ++i) places.push_back(static_cast<int>(i));
  return places;
}

/// As the adjustment gathers it, at the drive's own poses.
PathSurfaces surfaces_of(const Drive& d, const PathWeakness& weakness = {}) {
  return adjust_to_surfaces(d.graph, d.surfaces, {}, {}, weakness).path;
}

PathChain chain_of(const Drive& d) {
  PathChain chain;
  const std::size_t edges = d.poses.size() - 1;
  chain.drifts.assign(edges, Eigen::Vector3d(kStepM * kStepM, kStepM * kStepM, kStepRad * kStepRad)
                                 .asDiagonal()
                                 .toDenseMatrix());
  chain.open.assign(edges, false);
  chain.off.assign(edges, Eigen::Vector2d::Zero());
  return chain;
}

Eigen::Matrix3d by_steps(const Drive& d, const PathChain& chain, std::size_t first,
                         std::size_t last) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t i = first; i < last; ++i) {
    const Eigen::Matrix3d lever =
        lever_of(d.poses[last].translation() - d.poses[i + 1].translation());
    sum += lever * chain.drifts[i] * lever.transpose();
  }
  return sum;
}

double sigma_m(const Eigen::Matrix3d& covariance) {
  return largest_sigma(covariance.topLeftCorner<2, 2>());
}

TEST(PartByVisit, NoPatchIsSeenAcrossALeaveOrABreak) {
  const Drive d = twice_round_the_room();
  const auto keys = placed(d.poses);
  const SurfacePatches whole = find_patches(keys, d.surfaces, 0.2);
  std::vector<double> travelled_m{0.0};
  for (std::size_t i = 1; i < d.poses.size(); ++i)
    travelled_m.push_back(travelled_m.back() +
                          (d.poses[i].translation() - d.poses[i - 1].translation()).norm());
  std::vector<bool> broken(d.poses.size(), false);
  const auto middle = static_cast<int>(d.poses.size() / 2);
  broken[static_cast<std::size_t>(middle)] = true;
  const auto longest_gap_m = [&](const SurfacePatches& patches) {
    double gap_m = 0.0;
    for (const SharedSurface& patch : patches.patches)
      for (std::size_t i = patch.first + 1; i < patch.last; ++i)
        gap_m =
            std::max(gap_m, travelled_m[static_cast<std::size_t>(patches.sights[i].key)] -
                                travelled_m[static_cast<std::size_t>(patches.sights[i - 1].key)]);
    return gap_m;
  };
  ASSERT_GT(longest_gap_m(whole), kSurfaceAdjustment.visit_gap_m) << "all is seen twice";
  SurfacePatches parted = whole;
  part_by_visit(d.poses, {}, parted);
  EXPECT_GT(parted.patches.size(), whole.patches.size());
  EXPECT_LE(longest_gap_m(parted), kSurfaceAdjustment.visit_gap_m);
  parted = whole;
  part_by_visit(d.poses, broken, parted);
  for (const SharedSurface& patch : parted.patches) {
    EXPECT_GE(patch.last - patch.first, 2U);
    EXPECT_EQ(parted.sights[patch.first].key < middle, parted.sights[patch.last - 1].key < middle);
  }
}

TEST(ForgetOpenDirections, AMapMayMoveAsAWholeAndAlongACorridorEachKeyByItself) {
  const Drive d = down_a_corridor();
  const auto keys = placed(d.poses);
  SurfacePatches patches = find_patches(keys, d.surfaces, 0.2);
  // Every third key scan is said to know where it is.
  std::vector<bool> open(d.poses.size(), true);
  for (std::size_t i = 0; i < open.size(); i += 3) open[i] = false;
  forget_open_directions(keys, open, patches);
  const std::vector<int> places = all_in_place(d.poses.size());
  SurfaceSystem system(patches, places, places.size(), {}, SurfaceUse::kHold);
  system.linearise(keys, 0.01);
  const auto pull = [&](const std::vector<Eigen::Vector3d>& x) {
    std::vector<Eigen::Vector3d> y(x.size(), Eigen::Vector3d::Zero());
    system.multiply_add(x, y);
    double most = 0.0;
    for (const Eigen::Vector3d& block : y) most = std::max(most, block.cwiseAbs().maxCoeff());
    return most;
  };
  const std::size_t count = d.poses.size();
  const double across = pull({count, Eigen::Vector3d(0.0, 1.0, 0.0)});
  std::vector<Eigen::Vector3d> one_across(count, Eigen::Vector3d::Zero());
  one_across[10] = {0.0, 1.0, 0.0};
  EXPECT_LT(across, 1e-3 * pull(one_across)) << "all together";
  EXPECT_LT(pull({count, Eigen::Vector3d(1.0, 0.0, 0.0)}), 1e-3 * pull(one_across));
  std::vector<Eigen::Vector3d> turned;
  for (const Pose2& pose : d.poses) turned.emplace_back(-pose.y, pose.x, 1.0);
  EXPECT_LT(pull(turned), 1e-3 * pull(one_across)) << "no patch is a compass";
  std::vector<Eigen::Vector3d> one_along(count, Eigen::Vector3d::Zero());
  one_along[10] = {1.0, 0.0, 0.0};
  EXPECT_LT(pull(one_along), 1e-3 * pull(one_across)) << "a bare corridor holds no length";
}

TEST(PathPosterior, DrawsAreAsTheCovariancesSay) {
  const Drive d = twice_round_the_room();
  const PathSurfaces surfaces = surfaces_of(d);
  ASSERT_TRUE(surfaces.available());
  PathChain chain = chain_of(d);
  chain.factor = 4.0;
  PathPosterior posterior(surfaces, chain, chain.drifts);
  ASSERT_TRUE(posterior.available());
  const std::vector<Eigen::Vector2d> places = posterior.places();
  ASSERT_GT(places.size(), 5U);
  const std::size_t last = places.size() - 2;
  const auto nearest = [&](const Eigen::Vector2d& place) {
    return static_cast<std::size_t>(
        std::ranges::min_element(surfaces.poses(), {},
                                 [&](const Pose2& p) { return (p.translation() - place).norm(); }) -
        surfaces.poses().begin());
  };
  // Drawn as errors at two places; told as that of the motion between them.
  const std::size_t from = nearest(places[1]);
  const std::size_t to = nearest(places[last]);
  const Eigen::Matrix3d lever = lever_of(places[last] - places[1]);
  Eigen::Matrix3d drawn = Eigen::Matrix3d::Zero();
  constexpr int kDraws = 3000;
  const Rng rng(3);
  for (int i = 0; i < kDraws; ++i) {
    const std::vector<Eigen::Vector3d> errors =
        posterior.draw(rng.fork(static_cast<std::uint64_t>(i)));
    const Eigen::Vector3d off = errors[last] - lever * errors[1];
    drawn += off * off.transpose() / kDraws;
  }
  const Eigen::Matrix3d told = posterior.between(from, to);
  for (const int i : {0, 1, 2}) EXPECT_NEAR(drawn(i, i) / told(i, i), 1.0, 0.12) << i;
  EXPECT_EQ(posterior.draw(rng.fork(7)), posterior.draw(rng.fork(7)));
}

TEST(PathPosterior, SurfacesHoldAPathAndNotAcrossABreakThatOdometryDoesNotTie) {
  Drive d = twice_round_the_room();
  const PathChain chain = chain_of(d);
  const std::size_t last = d.poses.size() - 1;
  PathPosterior held(surfaces_of(d), chain, chain.drifts);
  const double held_m = sigma_m(held.between(0, last));
  EXPECT_LT(held_m, 0.5 * sigma_m(by_steps(d, chain, 0, last)));
  EXPECT_GT(held_m, 0.001);

  PathWeakness weakness{.broken = std::vector<bool>(d.poses.size(), false)};
  const std::size_t at = d.poses.size() / 2 + 3;
  weakness.broken[at] = true;
  PathChain torn = chain;
  torn.drifts[at - 1].diagonal() += Eigen::Vector3d(0.25, 0.25, 1e-4);
  PathPosterior told(surfaces_of(d, weakness), torn, torn.drifts);
  EXPECT_LT(sigma_m(told.between(at - 1, at)), 0.1)
      << "odometry tells which walls are the same on both sides";
  d.graph.edges[at - 1].information = torn.drifts[at - 1].inverse();
  PathPosterior parted(surfaces_of(d, weakness), torn, torn.drifts);
  EXPECT_NEAR(sigma_m(parted.between(at - 1, at)), 0.5, 0.05) << "nothing held it";
  PathPosterior unaware(surfaces_of(d), torn, torn.drifts);
  EXPECT_LT(sigma_m(unaware.between(0, last)), 0.1) << "the same walls would have";
}

TEST(PathPosterior, ACorridorIsAsLongAsItsStepsSay) {
  const Drive d = down_a_corridor();
  const PathSurfaces surfaces = surfaces_of(d);
  PathChain chain = chain_of(d);
  const std::size_t last = d.poses.size() - 1;
  PathPosterior posterior(surfaces, chain, chain.drifts);
  const Eigen::Matrix3d told = posterior.between(0, last);
  EXPECT_NEAR(std::sqrt(told(0, 0)), kStepM * std::sqrt(static_cast<double>(last)), 0.01);
  EXPECT_LT(std::sqrt(told(1, 1)), 0.2 * std::sqrt(by_steps(d, chain, 0, last)(1, 1)));
  // Odometry's scale, and where the laser was held back, pass as well.
  chain.open.assign(last, true);
  chain.scale_sigma = 0.02;
  EXPECT_NEAR(std::sqrt(PathPosterior(surfaces, chain, chain.drifts).between(0, last)(0, 0)),
              std::hypot(0.02 * 18.0, std::sqrt(told(0, 0))), 0.05)
      << "but for the last stretch, which is rigid";
  chain.scale_sigma = 0.0;
  chain.off[last / 2] = {-0.8, 0.3};
  EXPECT_NEAR(std::sqrt(PathPosterior(surfaces, chain, chain.drifts).between(0, last)(0, 0)),
              std::hypot(0.4, std::sqrt(told(0, 0))), 0.02);
}

TEST(PathPosterior, IsWhatMapsAreJudgedBy) {
  const Drive d = twice_round_the_room();
  std::vector<Stamp> stamps;
  for (std::size_t i = 0; i < d.poses.size(); ++i)
    stamps.push_back(Stamp::from_seconds(static_cast<double>(i)));
  std::vector<StepDrift> drifts(d.poses.size() - 1);
  for (StepDrift& drift : drifts) drift.covariance = chain_of(d).drifts.front();
  const auto ties = [&](const PathSurfaces& surfaces) {
    return find_ties_of(d.graph, {.stamps = stamps, .drifts = drifts, .surfaces = surfaces});
  };
  const GraphTies by_steps = ties({});
  const GraphTies held = ties(surfaces_of(d));
  EXPECT_LT(held.possible.m, 0.6 * by_steps.possible.m);
  EXPECT_LT(held.loose.at(0).sigma_m, 0.6 * by_steps.loose.at(0).sigma_m);
  EXPECT_GT(held.possible.m, held.loose.at(0).sigma_m * 0.2);
  EXPECT_NEAR(held.loose.at(0).path_m, by_steps.loose.at(0).path_m, 0.2);
}

}  // namespace
}  // namespace loopstone
