#include "loopstone/registration/match_sweep.hpp"

#include <gtest/gtest.h>

#include "loopstone/registration/weakest_direction.hpp"

namespace loopstone {
namespace {

/// A matcher that ends at the nearest of two headings, and tells of the second that it explains
/// less.
MatchResult two_minima(const Pose2& guess) {
  MatchResult match;
  const bool right = std::abs(guess.yaw) <= kPi / 2 + 0.1;
  match.target_T_source = {1.0, 2.0, right ? 0.1 : kPi - 0.1};
  match.score = right ? 0.9 : 0.7;
  match.status = MatchStatus::kConverged;
  return match;
}

TEST(MatchSweep, CountsWhoAgreesWithTheBest) {
  const CloudExtent<2> source{{0.5, 0.0}, 2.0};
  const std::vector<Pose2> starts = headings_from<2>({}, source, 8);
  const SweepResult<2> sweep = match_from<2>(starts, two_minima, source, 0.01);
  EXPECT_EQ(sweep.starts, 8);
  EXPECT_EQ(sweep.agreeing, 5) << "0, +-45 and +-90 deg";
  ASSERT_EQ(sweep.endings.size(), 2u);
  EXPECT_EQ(sweep.best().score, 0.9);
  EXPECT_EQ(sweep.endings[0].start, 0u);
  EXPECT_EQ(sweep.endings[1].count, 3);
}

TEST(MatchSweep, APoseThatTheDataSupportComesFirst) {
  MatchResult good{.status = MatchStatus::kConverged, .score = 0.5};
  MatchResult lost{.status = MatchStatus::kNotConverged, .score = 0.9};
  EXPECT_TRUE(is_better<2>(good, lost));
  EXPECT_FALSE(is_better<2>(lost, good));
  MatchResult closer = good;
  closer.rmse_m = -1.0;
  EXPECT_TRUE(is_better<2>(closer, good));
}

TEST(MatchSweep, HeadingsTurnAboutTheSourcesCentre) {
  const CloudExtent<2> flat{{3.0, -1.0}, 1.0};
  const Pose2 guess{0.5, 0.25, 0.3};
  const std::vector<Pose2> turned = headings_from<2>(guess, flat, 12);
  ASSERT_EQ(turned.size(), 12u);
  EXPECT_LT((turned[0].vector() - guess.vector()).norm(), 1e-12);
  for (const Pose2& start : turned) {
    EXPECT_LT((start * flat.centre - guess * flat.centre).norm(), 1e-12);
  }
  EXPECT_NEAR(turned[3].yaw, wrap_angle(0.3 + kPi / 2), 1e-12);

  const CloudExtent<3> deep{{3.0, -1.0, 2.0}, 1.0};
  const Pose3 guess3 = Pose3::from_roll_pitch_yaw({1, 2, 3}, 0.1, 0.2, 0.3);
  for (const Pose3& start : headings_from<3>(guess3, deep, 5)) {
    EXPECT_LT((start * deep.centre - guess3 * deep.centre).norm(), 1e-12);
    // Upright stays upright.
    EXPECT_NEAR((start.rotation * guess3.rotation.inverse() * Eigen::Vector3d::UnitZ()).z(), 1.0,
                1e-12);
  }
}

TEST(CloudExtent, CentreAndRadius) {
  const std::vector<Eigen::Vector2d> points{
      {0, 0}, {2, 0}, {std::nan(""), std::nan("")}, {2, 2}, {0, 2}};
  const CloudExtent<2> extent = cloud_extent<2>(points);
  EXPECT_EQ(extent.centre, Eigen::Vector2d(1, 1));
  EXPECT_DOUBLE_EQ(extent.radius_m, std::sqrt(2.0));
  EXPECT_EQ(cloud_extent<2>(std::vector<Eigen::Vector2d>{}).radius_m, 0.0);
}

TEST(CloudExtent, OptionsScaleWithTheCloud) {
  const IcpOptions small = icp_options_for_radius(0.05);
  const IcpOptions large = icp_options_for_radius(5.0);
  EXPECT_DOUBLE_EQ(small.max_pair_distance_m * 100.0, large.max_pair_distance_m);
  EXPECT_DOUBLE_EQ(small.kernel_width_m * 100.0, large.kernel_width_m);
  EXPECT_DOUBLE_EQ(small.point_sigma_m * 100.0, large.point_sigma_m);
  EXPECT_DOUBLE_EQ(large.point_sigma_m, IcpOptions{}.point_sigma_m);
}

TEST(WeakestDirection, NamesTheAxisOfACorridor) {
  MatchResult match;
  const double angle = 0.4;
  const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
  match.covariance.topLeftCorner<2, 2>() =
      25.0 * along * along.transpose() + 1e-6 * Eigen::Matrix2d::Identity();
  match.covariance(2, 2) = 1e-6;
  const WeakestDirection<2> weakest = weakest_direction<2>(match, 5.0);
  EXPECT_FALSE(weakest.is_turn);
  EXPECT_LT((weakest.direction - along).norm(), 1e-9);
  EXPECT_NEAR(weakest.sigma, 5.0, 1e-6);
  match.covariance(2, 2) = 4.0;
  EXPECT_TRUE(weakest_direction<2>(match, 5.0).is_turn);
  EXPECT_NEAR(weakest_direction<2>(match, 5.0).sigma, 2.0, 1e-12);
}

TEST(WeakestDirection, NamesTheAxisOfABottle) {
  MatchResult3 match;
  match.covariance.diagonal() << 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1.0;
  const WeakestDirection<3> weakest = weakest_direction<3>(match, 0.1);
  EXPECT_TRUE(weakest.is_turn);
  EXPECT_LT((weakest.direction - Eigen::Vector3d::UnitZ()).norm(), 1e-9);
}

}  // namespace
}  // namespace loopstone
