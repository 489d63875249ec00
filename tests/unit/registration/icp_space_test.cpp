#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/registration/icp.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using Cloud = std::vector<Eigen::Vector3d>;
using test::pose_near;

constexpr IcpMetric kMetrics[] = {IcpMetric::kPoint, IcpMetric::kPlane, IcpMetric::kGicp};

IcpOptions with_metric(IcpMetric metric) {
  IcpOptions options;
  options.metric = metric;
  options.max_pair_distance_m = 0.5;
  options.max_iterations = 150;
  return options;
}

/// Points scattered evenly over a rectangle.
void add_rectangle(Cloud& cloud, const Eigen::Vector3d& corner, const Eigen::Vector3d& u,
                   const Eigen::Vector3d& v, int count, Rng& rng, double noise_m) {
  const Eigen::Vector3d normal = u.cross(v).normalized();
  for (int i = 0; i < count; ++i) {
    cloud.push_back(corner + rng.uniform() * u + rng.uniform() * v +
                    rng.normal(0.0, noise_m) * normal);
  }
}

/// The corner of a room with a box in it, sampled anew at each call.
Cloud corner(Rng& rng, double noise_m) {
  Cloud cloud;
  add_rectangle(cloud, {0, 0, 0}, {3, 0, 0}, {0, 2, 0}, 500, rng, noise_m);
  add_rectangle(cloud, {0, 0, 0}, {3, 0, 0}, {0, 0, 2}, 500, rng, noise_m);
  add_rectangle(cloud, {0, 0, 0}, {0, 2, 0}, {0, 0, 2}, 350, rng, noise_m);
  add_rectangle(cloud, {1, 1, 0.6}, {0.6, 0.3, 0}, {-0.3, 0.6, 0}, 100, rng, noise_m);
  add_rectangle(cloud, {1, 1, 0}, {0.6, 0.3, 0}, {0, 0, 0.6}, 100, rng, noise_m);
  add_rectangle(cloud, {1, 1, 0}, {-0.3, 0.6, 0}, {0, 0, 0.6}, 100, rng, noise_m);
  return cloud;
}

Cloud transformed(const Pose3& target_T_source, const Cloud& source) {
  Cloud target;
  for (const Eigen::Vector3d& point : source) target.push_back(target_T_source * point);
  return target;
}

const Pose3 kTruth = Pose3::from_roll_pitch_yaw({0.1, -0.06, 0.05}, 0.03, -0.05, 0.08);

TEST(IcpInSpace, FindsTheMotionOfTheSamePoints) {
  Rng rng(71);
  const Cloud source = corner(rng, 0.0);
  const auto target = make_icp_cloud<3>(transformed(kTruth, source));
  for (const IcpMetric metric : {IcpMetric::kPlane, IcpMetric::kGicp}) {
    const MatchResult3 result = match_icp(source, target, {}, with_metric(metric));
    EXPECT_EQ(result.status, MatchStatus::kConverged) << to_string(metric);
    EXPECT_TRUE(pose_near(result.target_T_source, kTruth, 2e-3, 1e-3)) << to_string(metric);
    EXPECT_GT(result.score, 0.8) << to_string(metric);
  }
  // Point to point stops where every point has its neighbour's partner, unless it starts nearby.
  const Pose3 nearby = Pose3::from_roll_pitch_yaw({0.1, -0.055, 0.05}, 0.03, -0.048, 0.08);
  const MatchResult3 result = match_icp(source, target, nearby, with_metric(IcpMetric::kPoint));
  EXPECT_TRUE(pose_near(result.target_T_source, kTruth, 1e-6, 1e-6));
}

TEST(IcpInSpace, FindsTheMotionBetweenTwoSamples) {
  Rng rng(72);
  const auto target = make_icp_cloud<3>(transformed(kTruth, corner(rng, 0.005)));
  const auto source = make_icp_cloud<3>(corner(rng, 0.005));
  for (const IcpMetric metric : {IcpMetric::kPlane, IcpMetric::kGicp}) {
    const MatchResult3 result = match_icp(source, target, {}, with_metric(metric));
    EXPECT_EQ(result.status, MatchStatus::kConverged) << to_string(metric);
    EXPECT_TRUE(pose_near(result.target_T_source, kTruth, 5e-3, 3e-3)) << to_string(metric);
  }
}

TEST(IcpInSpace, BarePointsGiveWhatACloudGives) {
  Rng rng(73);
  const auto target = make_icp_cloud<3>(transformed(kTruth, corner(rng, 0.005)));
  const auto source = make_icp_cloud<3>(corner(rng, 0.005));
  for (const IcpMetric metric : kMetrics) {
    const MatchResult3 cloud = match_icp(source, target, {}, with_metric(metric));
    const MatchResult3 points = match_icp(source.points(), target, {}, with_metric(metric));
    EXPECT_TRUE(pose_near(cloud.target_T_source, points.target_T_source, 0.0, 0.0))
        << to_string(metric);
    EXPECT_EQ(cloud.covariance, points.covariance) << to_string(metric);
    EXPECT_EQ(cloud.iterations, points.iterations) << to_string(metric);
  }
}

TEST(IcpInSpace, CovarianceHoldsTheError) {
  for (const IcpMetric metric : {IcpMetric::kPlane, IcpMetric::kGicp}) {
    Rng rng(74);
    double sum = 0.0;
    constexpr int kDraws = 40;
    for (int draw = 0; draw < kDraws; ++draw) {
      const auto target = make_icp_cloud<3>(transformed(kTruth, corner(rng, 0.005)));
      const auto source = make_icp_cloud<3>(corner(rng, 0.005));
      const MatchResult3 result = match_icp(source, target, kTruth, with_metric(metric));
      const Tangent3 error = RigidMotion<3>::difference(result.target_T_source, kTruth);
      sum += error.dot(result.covariance.ldlt().solve(error));
    }
    EXPECT_GT(sum / kDraws, 3.0) << to_string(metric);  // ideally 6
    EXPECT_LT(sum / kDraws, 15.0) << to_string(metric);
  }
}

/// Every direction that the shape leaves open must be open, and keep the guess.
void expect_degenerate(const Cloud& cloud, const Pose3& guess,
                       const std::vector<Tangent3>& open_motions) {
  for (const IcpMetric metric : kMetrics) {
    const MatchResult3 result =
        match_icp(cloud, make_icp_cloud<3>(cloud), guess, with_metric(metric));
    EXPECT_EQ(result.status, MatchStatus::kDegenerate) << to_string(metric);
    EXPECT_FALSE(result.covariance.hasNaN()) << to_string(metric);
    for (const Tangent3& motion : open_motions) {
      const Tangent3 direction = motion.normalized();
      EXPECT_GT(direction.dot(result.covariance * direction), 1.0)
          << to_string(metric) << " " << motion.transpose();
    }
  }
}

Tangent3 motion(double x, double y, double z, double rx, double ry, double rz) {
  return (Tangent3() << x, y, z, rx, ry, rz).finished();
}

TEST(IcpInSpace, KnowsWhatAPlaneLeavesOpen) {
  Rng rng(75);
  Cloud plane;
  add_rectangle(plane, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, 1500, rng, 0.0);
  const Pose3 guess = Pose3::from_roll_pitch_yaw({0.1, 0.05, 0.04}, 0.02, 0.01, 0.05);
  expect_degenerate(plane, guess,
                    {motion(1, 0, 0, 0, 0, 0), motion(0, 1, 0, 0, 0, 0), motion(0, 0, 0, 0, 0, 1)});
  const MatchResult3 result =
      match_icp(plane, make_icp_cloud<3>(plane), guess, with_metric(IcpMetric::kPlane));
  EXPECT_NEAR(result.target_T_source.translation.x(), 0.1, 0.01);
  EXPECT_NEAR(result.target_T_source.translation.y(), 0.05, 0.01);
  EXPECT_NEAR(result.target_T_source.translation.z(), 0.0, 1e-3);
  EXPECT_LT(result.covariance(2, 2), 1e-4);
}

TEST(IcpInSpace, KnowsThatASphereTurnsFreely) {
  Rng rng(76);
  Cloud sphere;
  const Eigen::Vector3d centre(1.0, 2.0, -0.5);
  for (int i = 0; i < 3000; ++i) {
    sphere.push_back(centre +
                     Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal()).normalized());
  }
  // A turn about the centre moves the source's origin too.
  const auto about_centre = [&](const Eigen::Vector3d& axis) {
    const Eigen::Vector3d shift = -axis.cross(centre);
    return motion(shift.x(), shift.y(), shift.z(), axis.x(), axis.y(), axis.z());
  };
  expect_degenerate(sphere, Pose3::from_roll_pitch_yaw({0.03, 0.02, -0.02}, 0.01, 0.02, 0.01),
                    {about_centre(Eigen::Vector3d::UnitX()), about_centre(Eigen::Vector3d::UnitY()),
                     about_centre(Eigen::Vector3d::UnitZ())});
}

TEST(IcpInSpace, KnowsTheAxisOfACorridor) {
  Rng rng(77);
  Cloud corridor;
  add_rectangle(corridor, {-5, -1, 0}, {10, 0, 0}, {0, 0, 2}, 1500, rng, 0.0);
  add_rectangle(corridor, {-5, 1, 0}, {10, 0, 0}, {0, 0, 2}, 1500, rng, 0.0);
  add_rectangle(corridor, {-5, -1, 0}, {10, 0, 0}, {0, 2, 0}, 1500, rng, 0.0);
  expect_degenerate(corridor, Pose3::from_roll_pitch_yaw({0.15, 0.05, 0.02}, 0.0, 0.0, 0.01),
                    {motion(1, 0, 0, 0, 0, 0)});
}

TEST(IcpInSpace, SaysThatALineOrAHeapIsTooLittle) {
  Cloud line;
  for (int i = 0; i < 100; ++i) line.emplace_back(0.02 * i, 0.0, 0.0);
  const Cloud heap(50, Eigen::Vector3d(1.0, 1.0, 1.0));
  for (const Cloud& cloud : {line, heap}) {
    for (const IcpMetric metric : kMetrics) {
      const MatchResult3 result =
          match_icp(cloud, make_icp_cloud<3>(cloud), {}, with_metric(metric));
      EXPECT_NE(result.status, MatchStatus::kConverged) << to_string(metric);
      EXPECT_FALSE(result.covariance.hasNaN()) << to_string(metric);
      EXPECT_TRUE(result.target_T_source.translation.allFinite()) << to_string(metric);
      EXPECT_GT(result.covariance.trace(), 1.0) << to_string(metric);
    }
  }
}

TEST(IcpInSpace, ReturnsTheGuessWhenThereIsNothing) {
  Rng rng(78);
  const Cloud cloud = corner(rng, 0.0);
  const Cloud bad(10, Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
  for (const IcpMetric metric : kMetrics) {
    for (const Cloud& nothing : {Cloud{}, bad, Cloud(4, Eigen::Vector3d::Ones())}) {
      const MatchResult3 result =
          match_icp(nothing, make_icp_cloud<3>(cloud), kTruth, with_metric(metric));
      EXPECT_EQ(result.status, MatchStatus::kTooFewPairs) << to_string(metric);
      EXPECT_TRUE(pose_near(result.target_T_source, kTruth, 0.0, 0.0)) << to_string(metric);
    }
  }
}

TEST(IcpInSpace, HasNoLines) {
  EXPECT_THROW((void)match_icp(Cloud{}, make_icp_cloud<3>({}), {}, with_metric(IcpMetric::kLine)),
               UsageError);
}

}  // namespace
}  // namespace loopstone
