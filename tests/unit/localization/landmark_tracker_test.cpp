#include "loopstone/localization/landmark_tracker.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "landmark_scene.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

using test::hall_map;
using test::in_range;
using test::seen_from;

/// How a robot drives round in the hall, and what is odd about it.
struct Round {
  int readings = 100;
  bool names = false;
  bool one_at_a_time = false;  ///< a landmark a reading
  int carried_at = -1;         ///< reading before which it is put elsewhere, unknown to its wheels
  int blind_from = -1;
  int blind_to = -1;
  std::optional<InitialPose> initial{};
  LandmarkMap believed = hall_map();
  std::uint64_t seed = 1;
};

struct Followed {
  LocalizationResult result{};
  std::vector<Pose2> truth{};  ///< at each reading

  [[nodiscard]] double error_m(std::size_t reading) const {
    const std::size_t first = truth.size() - result.estimates.size();
    const Pose2& pose = result.estimates[reading - first].map_T_robot;
    return std::hypot(pose.x - truth[reading].x, pose.y - truth[reading].y);
  }
};

/// 0.1 m a reading on a circle of 4 m, wheels off by 3 %.
Followed follow(const Round& round) {
  LandmarkTrackingOptions options;
  options.max_range_m = 12.0;
  LandmarkTracker tracker(round.believed, RobotModel{}, options, round.initial);
  Rng rng(round.seed);
  const LandmarkMap map = hall_map();
  Followed followed;
  Pose2 truth{4.0, 0.0, kPi / 2.0};
  Pose2 odom;
  for (int i = 0; i < round.readings; ++i) {
    if (i == round.carried_at) truth = {-3.0, 2.0, -0.5};
    const Stamp stamp = Stamp::from_seconds(100.0 + 0.2 * i);
    tracker.add(OdometryPose{stamp, odom});
    auto landmarks = in_range(truth, map, 9.0);
    if (round.one_at_a_time)
      landmarks = {landmarks[static_cast<std::size_t>(i) % landmarks.size()]};
    if (i >= round.blind_from && i < round.blind_to) landmarks.clear();
    tracker.add(LandmarkReading{stamp, seen_from(truth, map, landmarks, round.names, rng)});
    followed.truth.push_back(truth);
    truth = truth * exp(Tangent2(0.1, 0.0, 0.025));
    odom =
        odom * exp(Tangent2(0.103 + rng.normal(0.0, 0.002), 0.0, 0.025 + rng.normal(0.0, 0.001)));
  }
  followed.result = tracker.finish();
  return followed;
}

TEST(LandmarkTracker, FollowsFromAGuess) {
  const Followed followed = follow({.initial = InitialPose{{4.4, -0.3, kPi / 2.0 + 0.2}}});
  ASSERT_EQ(followed.result.estimates.size(), 100U);
  for (std::size_t i = 1; i < 100; ++i) EXPECT_LT(followed.error_m(i), 0.05) << i;
  EXPECT_EQ(followed.result.estimates.back().state, LocalizationState::kTracking);
  EXPECT_TRUE(followed.result.had_odometry);
  EXPECT_NEAR(followed.result.path_length_m, 10.2, 0.3);
  EXPECT_TRUE(followed.result.warnings.empty());
}

TEST(LandmarkTracker, FindsItselfFromNowhereWithoutNames) {
  const Followed followed = follow({});
  ASSERT_EQ(followed.result.estimates.size(), 100U);
  for (std::size_t i = 0; i < 100; ++i) EXPECT_LT(followed.error_m(i), 0.06) << i;
  EXPECT_EQ(followed.result.searches.front().reason, "start");
  EXPECT_EQ(followed.result.estimates.back().state, LocalizationState::kTracking);
  EXPECT_GE(followed.result.estimates.back().landmarks, 4);
}

TEST(LandmarkTracker, FindsItselfByOneNamedLandmarkAReading) {
  const Followed followed = follow({.names = true, .one_at_a_time = true});
  ASSERT_GE(followed.result.estimates.size(), 98U) << "two landmarks tell a pose";
  EXPECT_LT(followed.error_m(99), 0.06);
  EXPECT_EQ(followed.result.estimates.back().state, LocalizationState::kTracking);
}

TEST(LandmarkTracker, ErrorsAreWhatTheCovarianceSays) {
  double sum = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Followed followed = follow({.readings = 40, .seed = seed});
    const LocalizationEstimate& last = followed.result.estimates.back();
    const Pose2& truth = followed.truth.back();
    const Eigen::Vector3d off{last.map_T_robot.x - truth.x, last.map_T_robot.y - truth.y,
                              wrap_angle(last.map_T_robot.yaw - truth.yaw)};
    sum += off.dot(last.covariance.ldlt().solve(off));
    ++count;
  }
  // 3 degrees of freedom; of 20 drives the mean is 3 +- 0.55. Process noise that is given with room
  // to spare makes it smaller.
  EXPECT_LT(sum / count, 4.6);
  EXPECT_GT(sum / count, 0.8);
}

TEST(LandmarkTracker, CarriedAwayItIsLostThenFindsItself) {
  const Followed followed = follow({.carried_at = 50});
  EXPECT_EQ(followed.result.estimates[49].state, LocalizationState::kTracking);
  EXPECT_EQ(followed.result.estimates.back().state, LocalizationState::kTracking);
  for (std::size_t i = 56; i < 100; ++i) EXPECT_LT(followed.error_m(i), 0.06) << i;
  for (std::size_t i = 50; i < 100; ++i) {
    if (followed.result.estimates[i].state == LocalizationState::kTracking) {
      EXPECT_LT(followed.error_m(i), 0.2) << "TRACKING while wrong, at " << i;
    }
  }
}

TEST(LandmarkTracker, BlindItGetsUncertainAndSaysSo) {
  const Followed followed = follow({.blind_from = 40, .blind_to = 95});
  const auto& estimates = followed.result.estimates;
  EXPECT_GT(estimates[94].covariance(0, 0), 10.0 * estimates[39].covariance(0, 0));
  EXPECT_EQ(estimates[60].landmarks, 0);
  EXPECT_FALSE(estimates[60].refined);
  EXPECT_LT(followed.error_m(99), 0.06) << "seen again, it is right again";
  EXPECT_EQ(followed.result.scans_dropped, 55);
}

TEST(LandmarkTracker, AnotherMapIsNotTracked) {
  Rng rng(77);
  std::vector<MappedLandmark> landmarks;
  for (int i = 0; i < 10; ++i)
    landmarks.push_back({i, {rng.uniform(-9.0, 9.0), rng.uniform(-9.0, 9.0)}});
  const Followed followed =
      follow({.initial = InitialPose{{4.0, 0.0, kPi / 2.0}}, .believed = LandmarkMap(landmarks)});
  const auto tracking =
      std::ranges::count_if(followed.result.estimates, [](const LocalizationEstimate& estimate) {
        return estimate.state == LocalizationState::kTracking;
      });
  EXPECT_LE(tracking, 5);
}

TEST(LandmarkTracker, SameInputSameBits) {
  const Followed one = follow({.carried_at = 30});
  const Followed other = follow({.carried_at = 30});
  ASSERT_EQ(one.result.estimates.size(), other.result.estimates.size());
  for (std::size_t i = 0; i < one.result.estimates.size(); ++i) {
    const LocalizationEstimate& a = one.result.estimates[i];
    const LocalizationEstimate& b = other.result.estimates[i];
    EXPECT_EQ(a.map_T_robot, b.map_T_robot);
    EXPECT_EQ(a.covariance, b.covariance);
    EXPECT_EQ(a.probability, b.probability);
  }
}

TEST(LandmarkTracker, EstimatesComeOneByOne) {
  LandmarkTracker tracker(hall_map(), RobotModel{}, {}, InitialPose{{4.0, 0.0, 1.5}});
  tracker.add(LandmarkReading{Stamp::from_seconds(1.0), {observed(3.0, 0.0, 0.1, 0.1)}});
  EXPECT_FALSE(tracker.next_update()) << "it waits for odometry of its time";
  tracker.add(OdometryPose{Stamp::from_seconds(1.0), {}});
  EXPECT_TRUE(tracker.next_update());
  EXPECT_FALSE(tracker.next_update());
  EXPECT_EQ(tracker.observations(), 1);
  EXPECT_EQ(tracker.scans_with_intensities(), 0);
}

TEST(LandmarkTracker, RefusesOptionsOutOfRange) {
  LandmarkTrackingOptions options;
  options.clutter_share = 2.0;
  EXPECT_THROW(LandmarkTracker(hall_map(), RobotModel{}, options, {}), std::exception);
}

}  // namespace
}  // namespace loopstone
