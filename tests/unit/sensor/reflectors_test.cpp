#include "loopstone/sensor/reflectors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

constexpr double kStep = radians(0.25);

/// A wall at 5 m all around, half as bright for each 10 m.
LaserScan round_wall(double range_m = 5.0) {
  LaserScan scan{.angle_min_rad = -kPi / 2.0,
                 .angle_increment_rad = kStep,
                 .range_max_m = 30.0,
                 .ranges_m = std::vector<float>(721, static_cast<float>(range_m))};
  scan.intensities.assign(scan.ranges_m.size(), 100.0F);
  return scan;
}

void shine(LaserScan& scan, std::size_t from, std::size_t to, float range_m,
           float intensity = 1000.0F) {
  for (std::size_t beam = from; beam <= to; ++beam) {
    scan.ranges_m[beam] = range_m;
    scan.intensities[beam] = intensity;
  }
}

std::vector<LandmarkObservation> found_in(const LaserScan& scan,
                                          const ReflectorOptions& options = {}) {
  return find_reflectors(scan, {}, Tangent2::Zero(), options);
}

TEST(FindReflectors, OneIsWhereItsBeamsAre) {
  LaserScan scan = round_wall();
  shine(scan, 400, 404, 5.0F);
  const auto found = found_in(scan);
  ASSERT_EQ(found.size(), 1U);
  const double bearing = scan.angle_rad(402);
  EXPECT_LT((found[0].point - 5.0 * Eigen::Vector2d(std::cos(bearing), std::sin(bearing))).norm(),
            1e-3);
  EXPECT_EQ(found[0].beams_beside_m.size(), 5U);
  EXPECT_FALSE(found[0].id);
  // Along the beam the range's deviation, across it that of the bearing at 5 m.
  const Eigen::Vector2d across(-found[0].direction.y(), found[0].direction.x());
  EXPECT_NEAR(std::sqrt(found[0].direction.dot(found[0].covariance * found[0].direction)), 0.01,
              1e-9);
  EXPECT_NEAR(std::sqrt(across.dot(found[0].covariance * across)),
              5.0 * std::hypot(0.001, kStep / std::sqrt(12.0)), 1e-4);
}

TEST(FindReflectors, BrightIsRelativeToTheRange) {
  // Far walls are faint: 100 at 5 m, 20 at 20 m. A reflector there is darker than a wall here.
  LaserScan scan = round_wall();
  for (std::size_t beam = 300; beam < 700; ++beam) {
    scan.ranges_m[beam] = 20.0F;
    scan.intensities[beam] = 20.0F;
  }
  shine(scan, 500, 503, 20.0F, 90.0F);
  const auto found = found_in(scan);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].point.norm(), 20.0, 0.01);
  EXPECT_TRUE(found_in(scan, {.brightness = 5.0}).empty());
  EXPECT_TRUE(found_in(scan, {.intensity_min = 95.0}).empty());
  EXPECT_EQ(found_in(scan, {.intensity_min = 85.0}).size(), 1U);
}

TEST(FindReflectors, APostIsADepthBehindItsFace) {
  constexpr double kRadius = 0.05;
  constexpr double kDistance = 3.0;
  LaserScan scan = round_wall();
  for (std::size_t beam = 0; beam < scan.ranges_m.size(); ++beam) {
    const double off = scan.angle_rad(beam) - 0.1;
    const double aside = kDistance * std::sin(off);
    if (std::abs(aside) >= kRadius || std::abs(off) > 1.0) continue;
    shine(scan, beam, beam,
          static_cast<float>(kDistance * std::cos(off) -
                             std::sqrt(kRadius * kRadius - aside * aside)));
  }
  const auto found = found_in(scan);
  ASSERT_EQ(found.size(), 1U);
  const Eigen::Vector2d centre = kDistance * Eigen::Vector2d(std::cos(0.1), std::sin(0.1));
  EXPECT_LT((centre_of(found[0], kRadius) - centre).norm(), 0.004);
  EXPECT_NEAR((found[0].point - centre).norm(), 0.04, 0.006) << "its face";
  EXPECT_EQ(centre_of(found[0], 0.0), found[0].point);
}

TEST(FindReflectors, WhatIsNoneIsLeftOut) {
  LaserScan scan = round_wall();
  shine(scan, 0, 3, 5.0F);      // at the scan's end
  shine(scan, 100, 100, 5.0F);  // a single beam
  shine(scan, 200, 240, 5.0F);  // 0.9 m wide
  shine(scan, 500, 503, 5.0F);  // behind something nearer
  scan.ranges_m[504] = 2.0F;
  for (std::size_t beam = 580; beam < 650; ++beam) scan.ranges_m[beam] = 25.0F;  // far away
  shine(scan, 600, 603, 25.0F);
  EXPECT_EQ(found_in(scan, {.range_max_m = 20.0}).size(), 0U);
  EXPECT_EQ(found_in(scan).size(), 1U);
  EXPECT_EQ(found_in(scan, {.beams_min = 1}).size(), 2U);
}

TEST(FindReflectors, ABeamWithoutReturnDoesNotPartOne) {
  LaserScan scan = round_wall();
  shine(scan, 400, 404, 5.0F);
  scan.ranges_m[402] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(found_in(scan).size(), 1U);
  scan.ranges_m[402] = 5.0F;
  scan.intensities[402] = 100.0F;
  EXPECT_EQ(found_in(scan).size(), 2U);
}

TEST(FindReflectors, TheMotionDuringTheSweepIsUndone) {
  LaserScan scan = round_wall();
  scan.time_increment_s = 1e-4;
  shine(scan, 400, 402, 5.0F);
  const Pose2 robot_T_lidar{0.2, 0.0, 0.1};
  const Tangent2 velocity(1.0, 0.0, 0.5);
  const auto found = find_reflectors(scan, robot_T_lidar, velocity, {});
  ASSERT_EQ(found.size(), 1U);
  const double bearing = scan.angle_rad(401);
  const Eigen::Vector2d expected =
      exp(Tangent2(velocity * 0.0401)) * robot_T_lidar *
      Eigen::Vector2d(5.0 * std::cos(bearing), 5.0 * std::sin(bearing));
  EXPECT_LT((found[0].point - expected).norm(), 1e-3);
}

TEST(FindReflectors, AStampThatMayBeOffCountsByHowFastItPasses) {
  LaserScan scan = round_wall();
  shine(scan, 359, 361, 5.0F);  // straight ahead
  const auto spread = [&](const Tangent2& velocity) {
    return find_reflectors(scan, {}, velocity, {.stamp_sigma_s = 0.02}).at(0).covariance;
  };
  const Eigen::Matrix2d still = spread(Tangent2::Zero());
  // Driving at it moves it along x, turning along y.
  EXPECT_NEAR(spread({1.0, 0.0, 0.0})(0, 0) - still(0, 0), 0.02 * 0.02, 1e-9);
  EXPECT_NEAR(spread({1.0, 0.0, 0.0})(1, 1) - still(1, 1), 0.0, 1e-9);
  EXPECT_NEAR(spread({0.0, 0.0, 1.0})(1, 1) - still(1, 1), 0.1 * 0.1, 1e-6);
}

TEST(FindReflectors, NoIntensitiesNoReflectors) {
  LaserScan scan = round_wall();
  shine(scan, 400, 404, 5.0F);
  scan.intensities.pop_back();
  EXPECT_TRUE(found_in(scan).empty());
  scan.intensities.clear();
  EXPECT_TRUE(found_in(scan).empty());
  scan = round_wall();
  scan.intensities.assign(scan.ranges_m.size(), 0.0F);
  EXPECT_TRUE(found_in(scan).empty()) << "a driver that fills in zeros";
}

TEST(Observed, IsPolar) {
  const LandmarkObservation seen = observed(2.0, kPi / 2.0, 0.1, 0.05, {1.0, 0.0, 0.0});
  EXPECT_LT((seen.point - Eigen::Vector2d(1.0, 2.0)).norm(), 1e-12);
  EXPECT_NEAR(seen.covariance(1, 1), 0.01, 1e-12);
  EXPECT_NEAR(seen.covariance(0, 0), 0.01, 1e-12);
  EXPECT_NEAR(seen.covariance(0, 1), 0.0, 1e-12);
}

}  // namespace
}  // namespace loopstone
