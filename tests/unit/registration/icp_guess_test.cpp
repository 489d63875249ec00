#include "loopstone/registration/icp_guess.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "loopstone/base/error.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

TEST(IcpGuess, CentroidsCoincide) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Eigen::Vector3d> source{{0, 0, 0}, {2, 0, 0}, {nan, 0, 0}};
  const std::vector<Eigen::Vector3d> target{{5, 1, 1}, {5, 3, 1}};
  const Pose3 guess = initial_guess<3>(IcpGuess::kCentroids, source, target);
  EXPECT_TRUE(test::pose_near(guess, {{4, 2, 1}, Eigen::Quaterniond::Identity()}, 1e-12, 1e-12));
  EXPECT_TRUE(
      test::pose_near(initial_guess<3>(IcpGuess::kIdentity, source, target), Pose3{}, 0.0, 0.0));
}

TEST(IcpGuess, OfNothingIsTheIdentity) {
  const std::vector<Eigen::Vector2d> some{{1.0, 2.0}};
  EXPECT_EQ(initial_guess<2>(IcpGuess::kCentroids, {}, some), Pose2{});
  EXPECT_EQ(initial_guess<2>(IcpGuess::kCentroids, some, {}), Pose2{});
}

}  // namespace
}  // namespace loopstone
