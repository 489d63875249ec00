#include "loopstone/geometry/pose3.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "support/generators.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using test::any_pose2;
using test::any_tangent3;
using test::pose_near;

TEST(Pose3, RollPitchYawTurnAboutFixedAxes) {
  const double quarter = 0.5 * kPi;
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  // REP-103: positive pitch tips the nose down, positive yaw turns left, positive roll lifts the
  // left side.
  EXPECT_TRUE((Pose3::from_roll_pitch_yaw(none, 0.0, quarter, 0.0) * x)
                  .isApprox(-Eigen::Vector3d::UnitZ()));
  EXPECT_TRUE(
      (Pose3::from_roll_pitch_yaw(none, 0.0, 0.0, quarter) * x).isApprox(Eigen::Vector3d::UnitY()));
  EXPECT_TRUE(
      (Pose3::from_roll_pitch_yaw(none, quarter, 0.0, 0.0) * Eigen::Vector3d::UnitY().eval())
          .isApprox(Eigen::Vector3d::UnitZ()));
  // Roll first, yaw last.
  EXPECT_TRUE(
      (Pose3::from_roll_pitch_yaw(none, quarter, 0.0, quarter) * Eigen::Vector3d::UnitY().eval())
          .isApprox(Eigen::Vector3d::UnitZ()));
}

TEST(Pose3, ExpOfAQuarterTurnIsAQuarterOfACircle) {
  Tangent3 twist;
  twist << kPi, 0.0, 1.0, 0.0, 0.0, 0.5 * kPi;
  const Pose3 pose = exp(twist);
  EXPECT_TRUE(pose.translation.isApprox(Eigen::Vector3d(2.0, 2.0, 1.0), 1e-12));
  EXPECT_NEAR(project_to_plane(pose).yaw, 0.5 * kPi, 1e-12);
}

TEST(Pose3, LogFindsHalfTurnsAboutAnyAxis) {
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(1.0, 0.0, 0.0), Eigen::Vector3d(0.0, -1.0, 0.0),
        Eigen::Vector3d(0.6, 0.0, -0.8)}) {
    Tangent3 twist = Tangent3::Zero();
    twist.tail<3>() = kPi * axis;
    const Tangent3 back = log(exp(twist));
    EXPECT_NEAR(back.tail<3>().norm(), kPi, 1e-9);
    EXPECT_NEAR(std::abs(back.tail<3>().normalized().dot(axis)), 1.0, 1e-12);
  }
}

RC_GTEST_PROP(Pose3Laws, ExpAndLogAreInverse, ()) {
  const Tangent3 twist = *any_tangent3();
  const Pose3 pose = exp(twist);
  RC_ASSERT(std::abs(pose.rotation.norm() - 1.0) < 1e-12);
  RC_ASSERT(pose_near(exp(log(pose)), pose, 1e-9, 1e-7));
  // Half turns have two logarithms.
  if (twist.tail<3>().norm() < kPi - 1e-6) RC_ASSERT((log(pose) - twist).norm() < 1e-8);
}

RC_GTEST_PROP(Pose3Laws, InverseUndoesAndProductsAct, ()) {
  const Pose3 a = exp(*any_tangent3());
  const Pose3 b = exp(*any_tangent3());
  RC_ASSERT(pose_near(a * a.inverse(), Pose3{}, 1e-11, 1e-7));
  const Eigen::Vector3d p(0.3, -4.0, 2.0);
  RC_ASSERT(((a * b) * p - a * (b * p)).norm() < 1e-11);
  RC_ASSERT((a.inverse() * (a * p) - p).norm() < 1e-11);
}

RC_GTEST_PROP(Pose3Laws, AdjointCarriesATwistThroughAPose, ()) {
  const Pose3 a = exp(*any_tangent3());
  const Tangent3 xi = *any_tangent3();
  const Tangent3 carried = adjoint(a) * xi;
  RC_ASSERT(pose_near(exp(carried) * a, a * exp(xi), 1e-8, 1e-7));
}

RC_GTEST_PROP(Pose3Laws, ThePlaneIsASubgroup, ()) {
  const Pose2 a = *any_pose2();
  const Pose2 b = *any_pose2();
  const Pose3 product = Pose3::from_pose2(a) * Pose3::from_pose2(b);
  RC_ASSERT(pose_near(product, Pose3::from_pose2(a * b), 1e-11, 1e-7));
  RC_ASSERT(pose_near(project_to_plane(product), a * b, 1e-11, 1e-10));
  RC_ASSERT(pose_near(project_to_plane(Pose3::from_pose2(a)), a, 1e-12, 1e-12));
}

RC_GTEST_PROP(Pose3Laws, SmallTurnsLoseNothing, ()) {
  // A tiny rotation vector must come back to full relative precision, not as zero.
  const double angle = std::pow(10.0, *test::between(-14.0, -2.0));
  Tangent3 twist;
  twist << 1.0, 2.0, 3.0, 0.6 * angle, 0.0, 0.8 * angle;
  const Tangent3 back = log(exp(twist));
  RC_ASSERT((back.tail<3>() - twist.tail<3>()).norm() < 1e-7 * angle);
  RC_ASSERT((back.head<3>() - twist.head<3>()).norm() < 1e-9);
}

}  // namespace
}  // namespace loopstone
