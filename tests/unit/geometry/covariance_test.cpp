#include "loopstone/geometry/covariance.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "support/generators.hpp"

namespace loopstone {
namespace {

const Eigen::Matrix3d kCovariance =
    (Eigen::Matrix3d() << 4.0, 0.5, 0.3, 0.5, 1.0, -0.2, 0.3, -0.2, 0.1).finished();

TEST(Covariance, AQuarterTurnSwapsTheAxes) {
  const Eigen::Matrix3d turned = rotated(kCovariance, Pose2{0.0, 0.0, radians(90.0)}.rotation());
  // What was x is y now, what was y is -x.
  const Eigen::Matrix3d expected =
      (Eigen::Matrix3d() << 1.0, -0.5, 0.2, -0.5, 4.0, 0.3, 0.2, 0.3, 0.1).finished();
  EXPECT_LT((turned - expected).norm(), 1e-12);
}

RC_GTEST_PROP(CovarianceLaws, ErrorsTurnAsVectorsDo, ()) {
  const Pose2 pose = *test::any_pose2();
  const Eigen::Matrix3d turned = rotated(kCovariance, pose.rotation());
  RC_ASSERT((turned - turned.transpose()).norm() < 1e-12);
  // How unlikely an error is does not depend on the axes.
  const Eigen::Vector3d error(0.3, -0.7, 0.05);
  Eigen::Vector3d there = error;
  there.head<2>() = pose.rotation() * error.head<2>();
  const double here2 = error.dot(kCovariance.inverse() * error);
  RC_ASSERT(std::abs(there.dot(turned.inverse() * there) - here2) < 1e-9 * here2);
  RC_ASSERT((rotated(turned, pose.rotation().transpose()) - kCovariance).norm() < 1e-12);
}

}  // namespace
}  // namespace loopstone
