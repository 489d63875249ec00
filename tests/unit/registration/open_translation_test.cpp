#include "registration/open_translation.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

/// Points of walls that face a direction, seen from a robot at the origin.
Eigen::Matrix3d hessian_of(double facing_rad, int points, double scatter_rad, Rng& rng) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int i = 0; i < points; ++i) {
    const double angle = facing_rad + scatter_rad * rng.normal();
    const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d point(rng.uniform(-8.0, 8.0), rng.uniform(-8.0, 8.0));
    const Eigen::Vector3d jacobian(normal.x(), normal.y(),
                                   normal.y() * point.x() - normal.x() * point.y());
    sum += jacobian * jacobian.transpose();
  }
  return sum;
}

TEST(OpenTranslation, IsTheWayAlongWallsThatFaceOneDirection) {
  Rng rng(1);
  for (const double facing : {0.0, 0.7, 1.5, 2.9}) {
    const Eigen::Matrix3d hessian = hessian_of(facing, 150, 0.03, rng);
    const auto open = open_translation(hessian);
    ASSERT_TRUE(open);
    const Eigen::Vector2d along(-std::sin(facing), std::cos(facing));
    EXPECT_GT(std::abs(open->motion.head<2>().dot(along)), 0.999);
    EXPECT_NEAR(open->motion.head<2>().norm(), 1.0, 1e-12);
    // Of all motions with that translation it is the one that the points resist least.
    EXPECT_NEAR((hessian * open->motion).z(), 0.0, 1e-9 * hessian(2, 2));
    EXPECT_NEAR(open->information, open->motion.dot(hessian * open->motion), 1e-9);
    EXPECT_LT(open->information, 2.0);
  }
}

TEST(OpenTranslation, IsNoneInACorner) {
  Rng rng(2);
  EXPECT_FALSE(open_translation(hessian_of(0.3, 100, 0.03, rng) + hessian_of(1.9, 20, 0.03, rng)));
}

TEST(OpenTranslation, IsWithoutInformationWhereNothingIsSeen) {
  const auto open = open_translation(Eigen::Matrix3d::Zero());
  ASSERT_TRUE(open);
  EXPECT_EQ(open->information, 0.0);
}

}  // namespace
}  // namespace loopstone
