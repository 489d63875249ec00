#include "loopstone/geometry/pose2.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <functional>

#include "loopstone/base/rng.hpp"
#include "support/generators.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using test::any_pose2;
using test::any_tangent2;
using test::pose_near;

constexpr double kTight = 1e-11;

Eigen::Matrix3d homogeneous(const Pose2& pose) {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  matrix.topLeftCorner<2, 2>() = pose.rotation();
  matrix.topRightCorner<2, 1>() = pose.translation();
  return matrix;
}

/// Central differences of a pose-valued function of (x, y, yaw).
Eigen::Matrix3d numeric_jacobian(const Pose2& at, const std::function<Pose2(const Pose2&)>& f) {
  constexpr double kStep = 1e-6;
  Eigen::Matrix3d result;
  for (int i = 0; i < 3; ++i) {
    Eigen::Vector3d low = at.vector();
    Eigen::Vector3d high = at.vector();
    low(i) -= kStep;
    high(i) += kStep;
    Eigen::Vector3d difference =
        f({high.x(), high.y(), high.z()}).vector() - f({low.x(), low.y(), low.z()}).vector();
    difference.z() = wrap_angle(difference.z());
    result.col(i) = difference / (2.0 * kStep);
  }
  return result;
}

TEST(Pose2, TurnsCounterClockwiseThenMoves) {
  const Pose2 map_T_robot{1.0, 2.0, 0.5 * kPi};
  const Eigen::Vector2d p =
      map_T_robot * Eigen::Vector2d(3.0, 0.0);  // 3 m ahead of a robot that looks north
  EXPECT_NEAR(p.x(), 1.0, 1e-15);
  EXPECT_NEAR(p.y(), 5.0, 1e-15);
  EXPECT_TRUE(pose_near(map_T_robot * Pose2{1.0, 0.0, 0.5 * kPi}, {1.0, 3.0, kPi}, 1e-15, 1e-15));
}

TEST(Pose2, ExpOfAQuarterTurnIsAQuarterOfACircle) {
  // Radius 2: arc length pi.
  EXPECT_TRUE(pose_near(exp(Tangent2(kPi, 0.0, 0.5 * kPi)), {2.0, 2.0, 0.5 * kPi}, 1e-12, 1e-12));
  EXPECT_TRUE(
      pose_near(exp(Tangent2(kPi, 0.0, -0.5 * kPi)), {2.0, -2.0, -0.5 * kPi}, 1e-12, 1e-12));
  EXPECT_EQ(exp(Tangent2(1.0, -2.0, 0.0)), (Pose2{1.0, -2.0, 0.0}));
}

TEST(Pose2, ExpFollowsTheArcThatManySmallStepsApproach) {
  const Tangent2 twist(1.0, 0.3, 2.5);
  Pose2 pose;
  constexpr int kSteps = 100'000;
  for (int i = 0; i < kSteps; ++i) {
    const Tangent2 step = twist / kSteps;
    pose = pose * Pose2{step.x(), step.y(), step.z()};
  }
  EXPECT_TRUE(pose_near(exp(twist), pose, 1e-4, 1e-9));
}

RC_GTEST_PROP(Pose2Laws, CompositionIsThatOfMatrices, ()) {
  const Pose2 a = *any_pose2();
  const Pose2 b = *any_pose2();
  RC_ASSERT(homogeneous(a * b).isApprox(homogeneous(a) * homogeneous(b), 1e-12));
  RC_ASSERT((a * b).yaw > -kPi && (a * b).yaw <= kPi);
  const Eigen::Vector2d p(0.3, -4.0);
  RC_ASSERT((((a * b) * p) - (a * (b * p))).norm() < kTight);
}

RC_GTEST_PROP(Pose2Laws, InverseUndoes, ()) {
  const Pose2 a = *any_pose2();
  RC_ASSERT(pose_near(a * a.inverse(), Pose2{}, kTight, kTight));
  RC_ASSERT(pose_near(a.inverse() * a, Pose2{}, kTight, kTight));
  RC_ASSERT(pose_near(a.inverse().inverse(), a, kTight, kTight));
}

RC_GTEST_PROP(Pose2Laws, ExpAndLogAreInverse, ()) {
  const Pose2 pose = *any_pose2();
  RC_ASSERT(pose_near(exp(log(pose)), pose, kTight, kTight));
  const Tangent2 twist = *any_tangent2();
  RC_ASSERT((log(exp(twist)) - twist).norm() < 1e-10);
}

RC_GTEST_PROP(Pose2Laws, AdjointCarriesATwistThroughAPose, ()) {
  const Pose2 a = *any_pose2();
  const Tangent2 xi = *any_tangent2();
  const Tangent2 carried = adjoint(a) * xi;
  RC_ASSERT(pose_near(exp(carried) * a, a * exp(xi), 1e-9, 1e-11));
  const Pose2 b = *any_pose2();
  RC_ASSERT(adjoint(a * b).isApprox(adjoint(a) * adjoint(b), 1e-10));
}

RC_GTEST_PROP(Pose2Laws, JacobiansAreTheDerivatives, ()) {
  const Pose2 a = *any_pose2();
  const Pose2 b = *any_pose2();
  const auto left = numeric_jacobian(a, [&](const Pose2& moved) { return moved * b; });
  const auto right = numeric_jacobian(b, [&](const Pose2& moved) { return a * moved; });
  const auto inverted = numeric_jacobian(a, [](const Pose2& moved) { return moved.inverse(); });
  RC_ASSERT((left - compose_jacobian_left(a, b)).norm() < 1e-7);
  RC_ASSERT((right - compose_jacobian_right(a, b)).norm() < 1e-7);
  RC_ASSERT((inverted - inverse_jacobian(a)).norm() < 1e-7);
}

RC_GTEST_PROP(Pose2Laws, InterpolationIsEvenAndReachesBothEnds, ()) {
  const Pose2 from = *any_pose2();
  const Tangent2 twist = *any_tangent2();
  const Pose2 to = from * exp(twist);
  RC_ASSERT(pose_near(interpolate(from, to, 0.0), from, kTight, kTight));
  RC_ASSERT(pose_near(interpolate(from, to, 1.0), to, 1e-10, 1e-10));
  const double ratio = *test::between(-1.0, 2.0);
  RC_ASSERT(
      pose_near(interpolate(from, to, ratio), from * exp(Tangent2(ratio * twist)), 1e-8, 1e-8));
}

RC_GTEST_PROP(Pose2Laws, InterpolationDoesNotDependOnTheFrame, ()) {
  const Pose2 from = *any_pose2();
  const Pose2 to = from * exp(*any_tangent2());
  const Pose2 a = *any_pose2();
  RC_ASSERT(
      pose_near(interpolate(a * from, a * to, 0.3), a * interpolate(from, to, 0.3), 1e-7, 1e-7));
}

RC_GTEST_PROP(Pose2Laws, InvertingTwiceKeepsTheCovariance, ()) {
  const Pose2 pose = *any_pose2();
  const Eigen::Matrix3d root =
      (Eigen::Matrix3d() << 0.2, 0.0, 0.0, 0.1, 0.3, 0.0, -0.02, 0.03, 0.05).finished();
  const PoseWithCovariance2 a{pose, root * root.transpose()};
  const auto same = inverse(inverse(a));
  RC_ASSERT(same.covariance.isApprox(a.covariance, 1e-9));
  // A pose and its own inverse, if independent, compound to identity in the mean.
  RC_ASSERT(pose_near(compound(a, inverse(a)).pose, Pose2{}, 1e-10, 1e-10));
}

/// Draws poses with the covariance given and returns that of f of them.
Eigen::Matrix3d monte_carlo(const PoseWithCovariance2& a, const PoseWithCovariance2& b,
                            const std::function<Pose2(const Pose2&, const Pose2&)>& f) {
  Rng rng(5);
  const Eigen::Matrix3d root_a = a.covariance.llt().matrixL();
  const Eigen::Matrix3d root_b = b.covariance.llt().matrixL();
  const Pose2 middle = f(a.pose, b.pose);
  const auto draw = [&rng](const Pose2& mean, const Eigen::Matrix3d& root) {
    const Eigen::Vector3d unit(rng.normal(), rng.normal(), rng.normal());
    const Eigen::Vector3d v = mean.vector() + root * unit;
    return Pose2{v.x(), v.y(), wrap_angle(v.z())};
  };
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  constexpr int kDraws = 200'000;
  for (int i = 0; i < kDraws; ++i) {
    const Pose2 first = draw(a.pose, root_a);
    const Pose2 second = draw(b.pose, root_b);
    Eigen::Vector3d off = f(first, second).vector() - middle.vector();
    off.z() = wrap_angle(off.z());
    sum += off * off.transpose() / kDraws;
  }
  return sum;
}

PoseWithCovariance2 uncertain(const Pose2& pose, double scale) {
  const Eigen::Matrix3d root =
      scale * (Eigen::Matrix3d() << 1.0, 0.0, 0.0, 0.4, 0.7, 0.0, -0.2, 0.3, 0.5).finished();
  return {pose, root * root.transpose()};
}

TEST(Covariance, CompoundAgreesWithMonteCarlo) {
  const auto a = uncertain({1.0, -2.0, 3.0}, 0.02);
  const auto b = uncertain({4.0, 1.0, -2.5}, 0.03);
  const auto c = compound(a, b);
  EXPECT_TRUE(pose_near(c.pose, a.pose * b.pose, 1e-15, 1e-15));
  const auto drawn = monte_carlo(a, b, [](const Pose2& x, const Pose2& y) { return x * y; });
  // To first order: what is left out has the size of scale^2, the draws' own error is
  // 1/sqrt(200,000).
  EXPECT_LT((c.covariance - drawn).norm(), 0.015 * drawn.norm()) << c.covariance << "\n\n" << drawn;
}

TEST(Covariance, InverseAgreesWithMonteCarlo) {
  const auto a = uncertain({5.0, -2.0, 2.0}, 0.02);
  const auto drawn = monte_carlo(a, a, [](const Pose2& x, const Pose2&) { return x.inverse(); });
  EXPECT_LT((inverse(a).covariance - drawn).norm(), 0.015 * drawn.norm());
}

}  // namespace
}  // namespace loopstone
