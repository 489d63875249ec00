#include "loopstone/slam/wall_axes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

using test::Walls;

/// What a robot saw that stood about in a place: poses in the place's frame.
struct Seen {
  std::vector<Pose2> poses{};
  std::vector<std::vector<SurfacePoint>> surfaces{};
};

Seen stand_about_in(const Walls& walls, double noise_m = 0.01) {
  Seen seen;
  Rng rng(5);
  BeamTable beams;
  for (const Eigen::Vector2d& at :
       {Eigen::Vector2d(1.5, 1.5), {4.0, 3.0}, {6.5, 1.5}, {3.0, 4.5}}) {
    const Pose2 pose{at.x(), at.y(), rng.uniform(-kPi, kPi)};
    const LaserScan scan = test::scan_from(walls, pose, {}, {.noise_m = noise_m}, &rng);
    seen.poses.push_back(pose);
    seen.surfaces.push_back(surface_points(scan, {}, Tangent2::Zero(), {}, beams));
  }
  return seen;
}

WallAxes axes_turned(const Seen& seen, double turn_rad) {
  std::vector<Pose2> poses = seen.poses;
  for (Pose2& pose : poses) pose = Pose2{3.0, -2.0, turn_rad} * pose;
  return wall_axes(poses, seen.surfaces);
}

/// From one direction to another, a quarter turn being none [rad].
double apart(double a, double b) { return std::remainder(a - b, 0.5 * kPi); }

TEST(WallAxes, TheWallsOfARoomHaveTheirOwn) {
  const WallAxes axes = axes_turned(stand_about_in(test::furnished_room()), 0.0);
  EXPECT_TRUE(axes.are_clear());
  EXPECT_GT(axes.share, 0.7);
  EXPECT_NEAR(degrees(axes.map_yaw_rad), 0.0, 0.2);
}

TEST(WallAxes, AnyTurnedWorldComesBack) {
  const Seen seen = stand_about_in(test::furnished_room());
  const double own = axes_turned(seen, 0.0).map_yaw_rad;
  for (double turn_deg = -180.0; turn_deg <= 180.0; turn_deg += 7.3) {
    const WallAxes axes = axes_turned(seen, radians(turn_deg));
    EXPECT_NEAR(degrees(apart(axes.map_yaw_rad, own + radians(turn_deg))), 0.0, 0.15) << turn_deg;
    EXPECT_LE(std::abs(axes.map_yaw_rad), 0.25 * kPi + 1e-9);
    EXPECT_TRUE(axes.are_clear());
    // Turned back, it is straight.
    EXPECT_NEAR(degrees(axes_turned(seen, radians(turn_deg) - axes.map_yaw_rad).map_yaw_rad), 0.0,
                0.15);
  }
}

TEST(WallAxes, ARoundPlaceHasNone) {
  Walls round;
  constexpr int kSides = 90;
  const auto corner = [](int i) {
    const double angle = 2.0 * kPi * i / kSides;
    return Eigen::Vector2d(4.0 + 4.0 * std::cos(angle), 3.0 + 4.0 * std::sin(angle));
  };
  for (int i = 0; i < kSides; ++i) round.push_back({corner(i), corner(i + 1)});
  EXPECT_FALSE(axes_turned(stand_about_in(round), 0.0).are_clear());
}

TEST(WallAxes, TwoWingsTurnedToOneAnotherHaveNoneInCommon) {
  Seen both = stand_about_in(test::furnished_room());
  const Seen one = both;
  for (std::size_t i = 0; i < one.poses.size(); ++i) {
    both.poses.push_back(Pose2{20.0, 0.0, radians(40.0)} * one.poses[i]);
    both.surfaces.push_back(one.surfaces[i]);
  }
  const WallAxes axes = wall_axes(both.poses, both.surfaces);
  EXPECT_FALSE(axes.are_clear());
  EXPECT_GT(axes.next_share, 0.3);
}

TEST(WallAxes, NothingSeenIsNothingKnown) {
  EXPECT_FALSE(wall_axes({}, {}).are_clear());
  EXPECT_EQ(wall_axes({}, {}).share, 0.0);
}

}  // namespace
}  // namespace loopstone
