// What moves against the ground that odometry drove over, and what stands.

#include "loopstone/slam/travelling_things.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

constexpr int kBeams = 361;
constexpr double kHalfWidth = 1.2;
constexpr double kEnd = 30.0;
constexpr float kNothing = std::numeric_limits<float>::infinity();

/// Of a corridor along x as a laser in its middle sees it, with something across it.
LaserScan corridor_from(double x, double something_at = kEnd) {
  LaserScan scan;
  scan.angle_min_rad = -0.5 * std::numbers::pi;
  scan.angle_increment_rad = std::numbers::pi / (kBeams - 1);
  scan.range_max_m = 40.0;
  for (int i = 0; i < kBeams; ++i) {
    const double angle = scan.angle_rad(static_cast<std::size_t>(i));
    const double aside = std::abs(std::sin(angle));
    const double to_wall = aside > 1e-9 ? kHalfWidth / aside : 1e9;
    const double to_end = (std::min(something_at, kEnd) - x) / std::max(std::cos(angle), 1e-9);
    scan.ranges_m.push_back(static_cast<float>(std::min(to_wall, to_end)));
  }
  return scan;
}

class Travelling : public testing::Test {
 protected:
  /// Drives so far that there are scans to compare with. \return what the last one shows
  template <typename AheadOf>
  std::vector<bool> drive(const AheadOf& ahead_of, double scale = 1.0,
                          const std::vector<bool>& covered = {}) {
    std::vector<bool> found;
    for (double x = 0.0; x < 2.05; x += 0.1) {
      const LaserScan scan = corridor_from(x, ahead_of(x));
      const Pose2 said{scale * x, 0.0, 0.0};
      found = things_.find(scan, said, scale * x, covered, beams_);
      things_.remember(scan, said, scale * x);
    }
    return found;
  }
  static std::ptrdiff_t count(const std::vector<bool>& beams) {
    return std::ranges::count(beams, true);
  }

  BeamTable beams_{};
  TravellingThings things_{};
};

TEST_F(Travelling, NothingThatStands) {
  EXPECT_TRUE(drive([](double) { return kEnd; }).empty());
  things_.forget();
  // Near as well.
  EXPECT_TRUE(drive([](double) { return 8.0; }).empty());
}

TEST_F(Travelling, WhatStaysAheadOfTheRobot) {
  const auto found = drive([](double x) { return x + 8.0; });
  ASSERT_FALSE(found.empty());
  const LaserScan last = corridor_from(2.0, 10.0);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double along = last.ranges_m[i] * std::cos(last.angle_rad(i));
    // The line, but for its ends, and nothing of the walls.
    const bool is_line = std::abs(last.angle_rad(i)) < 0.1;
    if (is_line || along < 7.0) {
      EXPECT_EQ(found[i], is_line) << i;
    }
  }
}

TEST_F(Travelling, WhatRunsAwayOrComesNear) {
  EXPECT_GE(count(drive([](double x) { return 6.0 + 3.0 * x; })), 20);
  things_.forget();
  EXPECT_GE(count(drive([](double x) { return 12.0 - x; })), 20);
}

TEST_F(Travelling, NotWhatIsCoveredAnyway) {
  EXPECT_TRUE(
      drive([](double x) { return x + 8.0; }, 1.0, std::vector<bool>(kBeams, true)).empty());
}

TEST_F(Travelling, NothingBeforeTheRobotHasGoneSomeWay) {
  const Pose2 here{0.2, 0.0, 0.0};
  things_.remember(corridor_from(0.0, 8.0), Pose2{}, 0.0);
  EXPECT_TRUE(things_.find(corridor_from(0.2, 8.2), here, 0.2, {}, beams_).empty());
  EXPECT_FALSE(things_.find(corridor_from(0.4, 8.4), {0.4, 0.0, 0.0}, 0.4, {}, beams_).empty());
}

TEST_F(Travelling, OfTheSameLaserOnly) {
  things_.remember(corridor_from(0.0, 8.0), Pose2{}, 0.0);
  LaserScan other = corridor_from(0.5, 8.5);
  other.lidar = 1;
  EXPECT_TRUE(things_.find(other, {0.5, 0.0, 0.0}, 0.5, {}, beams_).empty());
}

TEST_F(Travelling, NothingIsSaidWhereMostWouldMove) {
  // A room of which odometry knows nothing: the robot stands, and it says that it goes.
  LaserScan scan = corridor_from(0.0);
  std::ranges::fill(scan.ranges_m, 5.0F);
  things_.remember(scan, Pose2{}, 0.0);
  EXPECT_TRUE(things_.find(scan, {1.0, 0.0, 0.0}, 1.0, {}, beams_).empty());
}

/// The same where beams find nothing in front.
LaserScan open_ahead(LaserScan scan, float beyond_m, float instead) {
  for (float& range_m : scan.ranges_m) {
    if (range_m > beyond_m) range_m = instead;
  }
  return scan;
}

TEST_F(Travelling, WhatStandsWhereNothingWasIsNewUntilItIsSeenTwice) {
  const LaserScan before = open_ahead(corridor_from(0.0), 7.0F, kNothing);
  things_.remember(before, Pose2{}, 0.0);
  const LaserScan now = open_ahead(corridor_from(0.5, 6.5), 7.0F, kNothing);
  const auto found = things_.find_new(now, {0.5, 0.0, 0.0}, 0.5, {}, beams_);
  ASSERT_FALSE(found.empty());
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double aside = std::abs(now.angle_rad(i));
    if (aside < 0.1 || aside > 0.3) {
      EXPECT_EQ(found[i], aside < 0.1) << i;
    }
  }
  things_.remember(now, {0.5, 0.0, 0.0}, 0.5);
  const LaserScan again = open_ahead(corridor_from(1.0, 6.5), 7.0F, kNothing);
  EXPECT_TRUE(things_.find_new(again, {1.0, 0.0, 0.0}, 1.0, {}, beams_).empty());
  const LaserScan ahead = open_ahead(corridor_from(1.0, 7.0), 7.0F, kNothing);
  EXPECT_FALSE(things_.find_new(ahead, {1.0, 0.0, 0.0}, 1.0, {}, beams_).empty())
      << "it goes along";
}

TEST_F(Travelling, BeamsThatAreBadDenyNothing) {
  constexpr float kBad = std::numeric_limits<float>::quiet_NaN();
  things_.remember(open_ahead(corridor_from(0.0), 6.0F, kBad), Pose2{}, 0.0);
  const LaserScan now = corridor_from(0.5, 6.5);
  EXPECT_TRUE(things_.find_new(now, {0.5, 0.0, 0.0}, 0.5, {}, beams_).empty());
}

TEST_F(Travelling, WhatLiesBeyondTheLasersReachIsDeniedByNobody) {
  LaserScan before = open_ahead(corridor_from(0.0), 6.0F, kNothing);
  before.range_max_m = 6.0;
  things_.remember(before, Pose2{}, 0.0);
  LaserScan now = open_ahead(corridor_from(0.5, 6.3), 6.0F, kNothing);
  now.range_max_m = 6.0;
  EXPECT_TRUE(things_.find_new(now, {0.5, 0.0, 0.0}, 0.5, {}, beams_).empty());
}

TEST_F(Travelling, FewScansAreKept) {
  drive([](double) { return kEnd; });
  EXPECT_LE(things_.state().views.size(), 13U);
  EXPECT_GE(things_.state().views.back().path_m - things_.state().views.front().path_m,
            kTravelling.long_m);
}

TEST_F(Travelling, GoesOnFromItsState) {
  drive([](double x) { return x + 8.0; });
  TravellingThings again;
  again.restore(things_.state());
  const LaserScan scan = corridor_from(2.1, 10.1);
  EXPECT_EQ(again.find(scan, {2.1, 0.0, 0.0}, 2.1, {}, beams_),
            things_.find(scan, {2.1, 0.0, 0.0}, 2.1, {}, beams_));
  auto spoilt = things_.state();
  spoilt.views.front().ground_T_lidar.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(again.restore(spoilt), UsageError);
  spoilt = things_.state();
  spoilt.views.front().scan.angle_increment_rad = 0.0;
  EXPECT_THROW(again.restore(spoilt), UsageError);
}

TEST(LeaveOpen, BareCorridorsDo) {
  BeamTable beams;
  const auto surfaces_of = [&](const LaserScan& scan) {
    return surface_points(scan, Pose2{}, Tangent2::Zero(), {}, beams);
  };
  EXPECT_TRUE(leave_open(surfaces_of(corridor_from(0.0))));
  EXPECT_FALSE(leave_open(surfaces_of(corridor_from(0.0, 1.5))));
}

TEST(WeakestAxis, LiesAlongTheWallsOfACorridor) {
  const double yaw = 0.4;
  const Eigen::Vector2f across(static_cast<float>(-std::sin(yaw)),
                               static_cast<float>(std::cos(yaw)));
  const std::vector<SurfacePoint> surfaces(20, {{3.0F, 1.0F}, across, 1.0F});
  EXPECT_TRUE(leave_open(surfaces));
  const Eigen::Vector2d axis = weakest_axis(surfaces);
  EXPECT_NEAR(std::abs(axis.dot(Eigen::Vector2d(std::cos(yaw), std::sin(yaw)))), 1.0, 1e-6);
}

}  // namespace
}  // namespace loopstone
