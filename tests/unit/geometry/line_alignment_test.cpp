#include "loopstone/geometry/line_alignment.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

Eigen::Vector2d normal_at(double angle) { return {std::cos(angle), std::sin(angle)}; }

/// Points that lie on lines of all directions once `truth` has moved them, up to noise.
std::vector<PointOnLine> random_pairs(int count, const Pose2& truth, double noise_m, Rng& rng) {
  std::vector<PointOnLine> pairs;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d point(rng.uniform(-5.0, 5.0), rng.uniform(-5.0, 5.0));
    const Eigen::Vector2d normal = normal_at(rng.uniform(-kPi, kPi));
    const Eigen::Vector2d along(-normal.y(), normal.x());
    pairs.push_back(
        {point, truth * point + rng.uniform(-1.0, 1.0) * along + rng.normal(0.0, noise_m) * normal,
         normal, rng.uniform(0.1, 2.0)});
  }
  return pairs;
}

double cost_of(const std::vector<PointOnLine>& pairs, const Pose2& pose) {
  double cost = 0.0;
  for (const auto& pair : pairs) {
    const double residual = pair.normal.dot(pose * pair.point - pair.anchor);
    cost += pair.weight * residual * residual;
  }
  return cost;
}

TEST(LineAlignment, FindsAnyMotionExactly) {
  Rng rng(51);
  for (int draw = 0; draw < 200; ++draw) {
    const Pose2 truth{rng.uniform(-10.0, 10.0), rng.uniform(-10.0, 10.0), rng.uniform(-kPi, kPi)};
    const auto pairs = random_pairs(20, truth, 0.0, rng);
    const auto found = align_to_lines(pairs);
    EXPECT_TRUE(found.unique);
    EXPECT_TRUE(test::pose_near(to_pose(found), truth, 1e-7, 1e-7));
  }
}

TEST(LineAlignment, HasTheLeastCostOfAllMotions) {
  // The global minimum: no heading of a fine sweep does better, each with its own best translation.
  Rng rng(52);
  for (int draw = 0; draw < 30; ++draw) {
    const Pose2 truth{rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0), rng.uniform(-kPi, kPi)};
    const auto pairs = random_pairs(8, truth, 1.0, rng);  // noise as large as the motion
    const double least = cost_of(pairs, to_pose(align_to_lines(pairs)));
    for (double yaw = -kPi; yaw < kPi; yaw += 0.01) {
      Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
      Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
      for (const auto& pair : pairs) {
        const double residual = pair.normal.dot(Pose2{0.0, 0.0, yaw} * pair.point - pair.anchor);
        information += pair.weight * pair.normal * pair.normal.transpose();
        gradient += pair.weight * residual * pair.normal;
      }
      const Eigen::Vector2d shift = -information.ldlt().solve(gradient);
      EXPECT_LE(least, cost_of(pairs, {shift.x(), shift.y(), yaw}) * (1.0 + 1e-9));
    }
  }
}

TEST(LineAlignment, EqualsGaussNewtonAtTheMinimum) {
  Rng rng(53);
  for (int draw = 0; draw < 50; ++draw) {
    const Pose2 truth{rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0), rng.uniform(-0.3, 0.3)};
    const auto pairs = random_pairs(30, truth, 0.05, rng);
    Pose2 pose;
    for (int step = 0; step < 30; ++step) {
      Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
      Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
      for (const auto& pair : pairs) {
        const Eigen::Vector2d arm = pose.rotation() * pair.point;
        const Eigen::Vector3d row(pair.normal.x(), pair.normal.y(),
                                  pair.normal.y() * arm.x() - pair.normal.x() * arm.y());
        information += pair.weight * row * row.transpose();
        gradient += pair.weight * pair.normal.dot(pose * pair.point - pair.anchor) * row;
      }
      const Eigen::Vector3d motion = -information.ldlt().solve(gradient);
      pose = {pose.x + motion.x(), pose.y + motion.y(), wrap_angle(pose.yaw + motion.z())};
    }
    EXPECT_TRUE(test::pose_near(to_pose(align_to_lines(pairs)), pose, 1e-8, 1e-8));
  }
}

TEST(LineAlignment, SaysWhenLinesLeaveAMotionOpen) {
  std::vector<PointOnLine> corridor;
  std::vector<PointOnLine> circle;
  for (int i = 0; i < 20; ++i) {
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    corridor.push_back({{0.3 * i, side + 0.1}, {0.3 * i, side}, {0.0, 1.0}, 1.0});
    const Eigen::Vector2d outwards = normal_at(0.3 * i);
    circle.push_back({2.0 * outwards, 2.0 * outwards, outwards, 1.0});
  }
  EXPECT_FALSE(align_to_lines(corridor).unique);
  EXPECT_FALSE(align_to_lines(circle).unique);
  EXPECT_FALSE(align_to_lines({}).unique);
  // Along the corridor nothing moves; across it the points come to the walls.
  const Pose2 pose = to_pose(align_to_lines(corridor));
  EXPECT_NEAR(cost_of(corridor, pose), 0.0, 1e-12);
  const std::vector<PointOnLine> heap(5, {{1.0, 1.0}, {1.0, 1.0}, {0.0, 1.0}, 1.0});
  EXPECT_FALSE(align_to_lines(heap).unique);
  EXPECT_TRUE(align_to_lines(heap).rotation.allFinite());
}

TEST(LineAlignment, IgnoresPairsWithoutWeight) {
  Rng rng(54);
  const Pose2 truth{0.2, 0.1, 0.1};
  auto pairs = random_pairs(20, truth, 0.0, rng);
  pairs.push_back({{1.0, 1.0}, {100.0, 100.0}, {1.0, 0.0}, 0.0});
  EXPECT_TRUE(test::pose_near(to_pose(align_to_lines(pairs)), truth, 1e-8, 1e-8));
}

}  // namespace
}  // namespace loopstone
