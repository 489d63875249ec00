#include "loopstone/registration/correlative_match.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "map_scene.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using Points = std::vector<Eigen::Vector2d>;

TEST(CorrelativeMatch, FindsThePoseBetweenTheStepsOfTheLattice) {
  const World world = test::room_with_cabinet();
  const SurfaceIndex surfaces(world.plan);
  Rng rng(1);
  for (int trial = 0; trial < 20; ++trial) {
    const Pose2 map_T_target = test::place_in(world, surfaces, {0.8, 0.8}, {8.6, 5.4}, rng);
    // Not as far as the nearest wall.
    const Pose2 truth{rng.uniform(-0.2, 0.2), rng.uniform(-0.2, 0.2), rng.uniform(-0.3, 0.3)};
    const auto target = test::scan_at(surfaces, map_T_target, rng);
    const auto source = test::scan_at(surfaces, map_T_target * truth, rng);
    const auto result =
        match_correlative(source, make_correlative_target(target, 0.5), {{}, 0.5, 0.35});
    if (result.match.status == MatchStatus::kNotConverged) continue;  // a view past a corner
    EXPECT_TRUE(test::pose_near(result.match.target_T_source, truth, 0.03, radians(0.5))) << trial;
    EXPECT_GT(result.match.score, result.second_score);
    EXPECT_GT(result.match.pairs, 100);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(result.match.covariance);
    EXPECT_GT(eigen.eigenvalues()(0), 0.0);
    EXPECT_LT(eigen.eigenvalues()(2), 0.01);
  }
}

/// Points on two walls along x, closer together than a cell.
Points corridor(double from, double to) {
  Points points;
  for (double x = from; x <= to; x += 0.02) {
    points.emplace_back(x, -1.0);
    points.emplace_back(x, 1.0);
  }
  return points;
}

TEST(CorrelativeMatch, ACorridorIsOpenAlongItsAxis) {
  const auto target = make_correlative_target(corridor(-20.0, 20.0), 1.0);
  const auto result = match_correlative(corridor(-3.0, 3.0), target, {{0.1, 0.1, 0.05}, 1.0, 0.2});
  EXPECT_EQ(result.match.status, MatchStatus::kDegenerate);
  EXPECT_NEAR(result.match.target_T_source.y, 0.0, 0.02);
  EXPECT_NEAR(result.match.target_T_source.yaw, 0.0, 0.01);
  EXPECT_GT(std::sqrt(result.match.covariance(0, 0)), 0.3);
  EXPECT_LT(std::sqrt(result.match.covariance(1, 1)), 0.05);
}

Points corner_at(const Eigen::Vector2d& at) {
  Points points;
  for (double s = 0.0; s < 1.5; s += 0.02) {
    points.push_back(at + Eigen::Vector2d(s, 0.0));
    points.push_back(at + Eigen::Vector2d(0.0, s));
  }
  return points;
}

TEST(CorrelativeMatch, ASecondPlaceThatFitsAsWellIsSeen) {
  const Points source = corner_at({0.0, 0.0});
  Points both = source;
  const auto once =
      match_correlative(source, make_correlative_target(both, 3.0), {{0.2, 0.1, 0.0}, 3.0, 0.3});
  EXPECT_EQ(once.match.status, MatchStatus::kConverged);
  EXPECT_LT(once.second_score, 0.8 * once.match.score);
  for (const auto& point : corner_at({2.0, -1.0})) both.push_back(point);
  const auto twice =
      match_correlative(source, make_correlative_target(both, 3.0), {{0.2, 0.1, 0.0}, 3.0, 0.3});
  EXPECT_EQ(twice.match.status, MatchStatus::kDegenerate);
  EXPECT_GT(twice.second_score, 0.95 * twice.match.score);
  EXPECT_GT(twice.match.covariance(0, 0), 0.5);
}

TEST(CorrelativeMatch, NothingGoodEnoughIsNoMatch) {
  const auto target = make_correlative_target(corner_at({40.0, 0.0}), 0.5);
  const SearchWindow window{{0.3, 0.2, 0.1}, 0.5, 0.2};
  const auto result = match_correlative(corner_at({0.0, 0.0}), target, window);
  EXPECT_EQ(result.match.status, MatchStatus::kNotConverged);
  EXPECT_EQ(result.match.target_T_source, window.centre);
  EXPECT_EQ(match_correlative({}, target, window).match.status, MatchStatus::kNotConverged);
}

}  // namespace
}  // namespace loopstone
