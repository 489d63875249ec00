#include "loopstone/sensor/scan_points.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "loopstone/geometry/angle.hpp"
#include "support/generators.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

using test::distance_to_walls;
using test::Scanner;
using test::Walls;

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

std::vector<SurfacePoint> surfaces_of(const LaserScan& scan, const Pose2& robot_T_lidar = {},
                                      const SurfaceOptions& options = {},
                                      const Tangent2& velocity = Tangent2::Zero()) {
  BeamTable beams;
  return surface_points(scan, robot_T_lidar, velocity, options, beams);
}

/// The side of the wall that a point lies on must be the side of the sensor, and the normal that of
/// the wall.
double normal_error(const Walls& walls, const SurfacePoint& surface) {
  const Eigen::Vector2d at = surface.position.cast<double>();
  double error = kPi;
  for (const auto& wall : walls) {
    if (distance_to_walls({wall}, at) > 0.005) continue;
    const Eigen::Vector2d along = (wall.to - wall.from).normalized();
    error = std::min(
        error,
        std::abs(std::asin(std::clamp(along.dot(surface.normal.cast<double>()), -1.0, 1.0))));
  }
  return error;
}

TEST(ScanPoints, BeamsPointCounterClockwiseFromTheLidarsXAxis) {
  const LaserScan scan{.angle_min_rad = -0.5 * kPi,
                       .angle_increment_rad = 0.5 * kPi,
                       .range_max_m = 10.0,
                       .ranges_m = {1.0F, 2.0F, 3.0F}};
  const auto points = scan_points(scan, {0.5, 0.0, 0.0});
  ASSERT_EQ(points.size(), 3U);
  EXPECT_TRUE(points[0].isApprox(Eigen::Vector2d(0.5, -1.0), 1e-9));
  EXPECT_TRUE(points[1].isApprox(Eigen::Vector2d(2.5, 0.0), 1e-9));
  EXPECT_TRUE(points[2].isApprox(Eigen::Vector2d(0.5, 3.0), 1e-9));
  // A lidar mounted looking back and to the left.
  const auto turned = scan_points(scan, {-0.2, 0.1, kPi});
  EXPECT_TRUE(turned[0].isApprox(Eigen::Vector2d(-0.2, 1.1), 1e-9));
  EXPECT_TRUE(turned[1].isApprox(Eigen::Vector2d(-2.2, 0.1), 1e-9));
}

TEST(ScanPoints, OnlyReturnsWithinTheScannersRangeArePoints) {
  LaserScan scan{.angle_increment_rad = 0.01, .range_min_m = 0.1, .range_max_m = 5.0};
  scan.ranges_m = {kNaN, kInf, -kInf,  -1.0F,   0.0F,   0.0999F,
                   0.5F, kNaN, 4.999F, 5.0001F, 81.83F, 3e38F};
  EXPECT_EQ(scan_points(scan, {}).size(), 2U);
  EXPECT_EQ(surfaces_of(scan, {}, {.spacing_m = 0.001}).size(), 2U);
  EXPECT_EQ(surfaces_of(scan, {}, {.spacing_m = 0.001, .range_max_m = 1.0}).size(), 1U);
  // Even where the scanner claims that zero is within range.
  scan.range_min_m = 0.0;
  scan.ranges_m = {0.0F, -0.0F, 1.0F};
  EXPECT_EQ(scan_points(scan, {}).size(), 1U);
}

TEST(ScanPoints, NoBeamsAndNoReturnsGiveNoPoints) {
  EXPECT_TRUE(scan_points({}, {}).empty());
  EXPECT_TRUE(surfaces_of({}).empty());
  LaserScan blind{.angle_increment_rad = 0.01, .range_max_m = 10.0};
  blind.ranges_m.assign(180, kInf);
  EXPECT_TRUE(scan_points(blind, {}).empty());
  EXPECT_TRUE(surfaces_of(blind).empty());
  // A single beam has no increment to speak of.
  const LaserScan single{.range_max_m = 10.0, .ranges_m = {2.0F}};
  ASSERT_EQ(surfaces_of(single).size(), 1U);
  EXPECT_LT(surfaces_of(single).front().weight, 1.0F);
}

TEST(ScanPoints, DeskewUndoesAKnownMotion) {
  const Walls room = test::furnished_room();
  const Pose2 world_T_robot{4.0, 3.0, 0.4};
  const Pose2 robot_T_lidar{0.14, 0.05, -0.2};
  const Scanner slow{.time_increment_s = 0.1 / 541};
  for (const Tangent2& velocity :
       {Tangent2(1.5, 0.0, 0.0), Tangent2(0.0, 0.0, 2.0), Tangent2(-0.5, 0.2, -1.5)}) {
    const auto scan = test::scan_from(room, world_T_robot, robot_T_lidar, slow, nullptr, velocity);
    double worst = 0.0;
    double worst_uncorrected = 0.0;
    for (const auto& p : scan_points(scan, robot_T_lidar, velocity)) {
      worst = std::max(worst, distance_to_walls(room, world_T_robot * p));
    }
    for (const auto& p : scan_points(scan, robot_T_lidar)) {
      worst_uncorrected = std::max(worst_uncorrected, distance_to_walls(room, world_T_robot * p));
    }
    EXPECT_LT(worst, 1e-5);
    EXPECT_GT(worst_uncorrected, 0.03) << "the motion was too small to test anything";
    for (const auto& surface : surfaces_of(scan, robot_T_lidar, {}, velocity)) {
      EXPECT_LT(distance_to_walls(room, world_T_robot * surface.position.cast<double>().eval()),
                0.08);
    }
  }
}

TEST(ScanPoints, WithoutATimeIncrementTheVelocityChangesNothing) {
  const auto scan = test::scan_from(test::furnished_room(), {4.0, 3.0, 0.4}, {}, {});
  EXPECT_EQ(scan_points(scan, {}), scan_points(scan, {}, {1.0, 2.0, 3.0}));
}

TEST(SurfacePoints, LieOnTheWallAndFaceTheSensor) {
  const Walls room = test::furnished_room();
  const Pose2 robot_T_lidar{0.1, 0.0, 0.5};
  for (const Pose2& world_T_robot :
       {Pose2{4.0, 3.0, 0.0}, Pose2{1.0, 1.0, 2.0}, Pose2{5.5, 5.0, -2.5}}) {
    const auto scan = test::scan_from(room, world_T_robot, robot_T_lidar, {});
    const auto surfaces = surfaces_of(scan, robot_T_lidar);
    ASSERT_GT(surfaces.size(), 100U);
    const Eigen::Vector2d lidar = (world_T_robot * robot_T_lidar).translation();
    std::size_t exact = 0;
    for (const auto& surface : surfaces) {
      const Eigen::Vector2d at = world_T_robot * surface.position.cast<double>().eval();
      const Eigen::Vector2d normal = world_T_robot.rotation() * surface.normal.cast<double>();
      EXPECT_NEAR(normal.norm(), 1.0, 1e-5);
      EXPECT_GT(normal.dot(lidar - at), 0.0) << "a surface faces away from who saw it";
      EXPECT_LT(distance_to_walls(room, at), 0.06) << "within the reach of a rounded corner";
      const SurfacePoint in_world{at.cast<float>(), normal.cast<float>(), surface.weight};
      if (surface.weight == 1.0F && normal_error(room, in_world) < 0.002) ++exact;
    }
    // The rest lies within reach of a corner.
    EXPECT_GT(static_cast<double>(exact), 0.8 * static_cast<double>(surfaces.size()));
  }
}

TEST(SurfacePoints, AwayFromCornersAWallHasExactlyItsNormal) {
  const Walls wall{{{2.0, -3.0}, {2.6, 3.0}}};
  const Eigen::Vector2d expected = Eigen::Vector2d(-6.0, 0.6).normalized();
  const auto scan = test::scan_from(wall, {}, {}, {});
  const auto surfaces = surfaces_of(scan);
  ASSERT_GT(surfaces.size(), 50U);
  for (const auto& surface : surfaces) {
    EXPECT_LT(distance_to_walls(wall, surface.position.cast<double>()), 1e-4);
    EXPECT_GT(surface.normal.cast<double>().dot(expected), 1.0 - 1e-5);
    EXPECT_EQ(surface.weight, 1.0F);
  }
}

TEST(SurfacePoints, AverageTheNoiseOfTheirNeighbours) {
  const Walls wall{{{2.0, -3.0}, {2.0, 3.0}}};
  Rng rng(4);
  const Scanner noisy{.noise_m = 0.02};
  double raw = 0.0;
  double fitted = 0.0;
  int raw_count = 0;
  int fitted_count = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const auto scan = test::scan_from(wall, {}, {}, noisy, &rng);
    for (const auto& p : scan_points(scan, {})) {
      if (std::abs(p.y()) > 1.0) continue;
      raw += std::pow(p.x() - 2.0, 2);
      ++raw_count;
    }
    for (const auto& s : surfaces_of(scan)) {
      if (std::abs(s.position.y()) > 1.0F || s.weight < 1.0F) continue;
      fitted += std::pow(s.position.x() - 2.0, 2);
      ++fitted_count;
    }
  }
  EXPECT_LT(std::sqrt(fitted / fitted_count), 0.6 * std::sqrt(raw / raw_count));
}

TEST(SurfacePoints, DoNotBridgeABreak) {
  // A near wall hides part of a far one; between them there is nothing.
  for (const double gap : {0.3, 0.6, 2.0}) {
    const Walls walls{{{2.0, -3.0}, {2.0, 0.0}}, {{2.0 + gap, -3.0}, {2.0 + gap, 3.0}}};
    for (const auto& surface :
         surfaces_of(test::scan_from(walls, {}, {}, {}), {}, {.support_m = 0.5})) {
      EXPECT_LT(distance_to_walls(walls, surface.position.cast<double>()), 1e-4) << "gap " << gap;
      if (surface.weight == 1.0F) {
        EXPECT_GT(std::abs(surface.normal.x()), 0.999F) << "gap " << gap;
      }
    }
  }
}

TEST(SurfacePoints, SmallThingsWithoutALineAreGuessesAlongTheBeam) {
  // A table leg that two beams hit.
  LaserScan scan{.angle_min_rad = -0.01, .angle_increment_rad = 0.01, .range_max_m = 10.0};
  scan.ranges_m = {kInf, 2.0F, 2.0F, kInf};
  const auto surfaces = surfaces_of(scan, {}, {.spacing_m = 0.001});
  ASSERT_EQ(surfaces.size(), 2U);
  for (const auto& surface : surfaces) {
    EXPECT_LT(surface.weight, 1.0F);
    EXPECT_LT(surface.normal.dot(surface.position.normalized()), -0.9999F);
  }
}

TEST(SurfacePoints, LoneReturnsOnAGrazingWallAreLeftOut) {
  // Seen at 1 deg the returns lie metres apart: their normals can't be told, and along the beam
  // would be wrong by 89 deg.
  const Walls wall{{{1.0, 0.3}, {60.0, 1.3}}};
  const Scanner coarse{
      .angle_min_rad = 0.0, .angle_increment_rad = radians(0.25), .beams = 60, .range_max_m = 50.0};
  const auto scan = test::scan_from(wall, {}, {}, coarse);
  ASSERT_GT(scan_points(scan, {}).size(), 40U);
  for (const auto& surface : surfaces_of(scan)) {
    EXPECT_LT(surface.normal.y(), -0.99F) << "at " << surface.position.transpose();
  }
}

TEST(SurfacePoints, ThinningKeepsDistanceCoverageAndTheLimit) {
  const Walls room = test::furnished_room();
  const Scanner fine{
      .angle_min_rad = -kPi, .angle_increment_rad = 2.0 * kPi / 4000.0, .beams = 4000};
  const auto scan = test::scan_from(room, {4.0, 3.0, 0.0}, {}, fine);
  const SurfaceOptions options{.spacing_m = 0.05, .points_max = 100'000};
  const auto surfaces = surfaces_of(scan, {}, options);
  std::size_t close = 0;
  for (std::size_t i = 1; i < surfaces.size(); ++i) {
    if ((surfaces[i].position - surfaces[i - 1].position).norm() < 0.049F) ++close;
  }
  EXPECT_LT(close, surfaces.size() / 20) << "more than what fitting moves near corners";
  for (const auto& p : scan_points(scan, {})) {
    double nearest = 1e9;
    for (const auto& s : surfaces)
      nearest = std::min(nearest, (s.position.cast<double>() - p).norm());
    EXPECT_LT(nearest, 0.05 + 0.03) << "a return is represented by nobody";
  }
  for (const int limit : {1, 5, 50, 360}) {
    const auto few = surfaces_of(scan, {}, {.points_max = limit});
    EXPECT_LE(few.size(), static_cast<std::size_t>(limit));
    EXPECT_GE(few.size(), static_cast<std::size_t>(limit / 2)) << "thinned far more than asked";
  }
}

TEST(SurfacePoints, ClockwiseScannersSeeTheSame) {
  const Walls room = test::furnished_room();
  const Pose2 world_T_robot{3.0, 2.5, 1.0};
  const Scanner clockwise{.angle_min_rad = 2.0, .angle_increment_rad = -0.01, .beams = 401};
  auto scan = test::scan_from(room, world_T_robot, {}, clockwise);
  LaserScan mirrored = scan;  // the same beams, listed the other way round
  mirrored.angle_min_rad = -2.0;
  mirrored.angle_increment_rad = 0.01;
  std::reverse(mirrored.ranges_m.begin(), mirrored.ranges_m.end());

  auto points = scan_points(scan, {});
  std::reverse(points.begin(), points.end());
  const auto expected = scan_points(mirrored, {});
  ASSERT_EQ(points.size(), expected.size());
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_LT((points[i] - expected[i]).norm(), 1e-6);

  const Eigen::Vector2d lidar = world_T_robot.translation();
  for (const auto& surface : surfaces_of(scan)) {
    const Eigen::Vector2d at = world_T_robot * surface.position.cast<double>().eval();
    EXPECT_LT(distance_to_walls(room, at), 0.06);
    EXPECT_GT((world_T_robot.rotation() * surface.normal.cast<double>()).dot(lidar - at), 0.0);
  }
}

TEST(BeamTable, FollowsAChangeOfScanner) {
  BeamTable beams;
  LaserScan scan{.angle_min_rad = 0.0, .angle_increment_rad = 0.5 * kPi};
  scan.ranges_m.resize(2);
  EXPECT_TRUE(beams.directions(scan).at(1).isApprox(Eigen::Vector2d(0.0, 1.0), 1e-12));
  scan.angle_min_rad = kPi;
  EXPECT_TRUE(beams.directions(scan).at(1).isApprox(Eigen::Vector2d(0.0, -1.0), 1e-12));
  scan.angle_increment_rad = -0.5 * kPi;
  EXPECT_TRUE(beams.directions(scan).at(1).isApprox(Eigen::Vector2d(0.0, 1.0), 1e-12));
  scan.ranges_m.resize(5);
  EXPECT_EQ(beams.directions(scan).size(), 5U);
}

RC_GTEST_PROP(SurfacePointLaws, MovingTheMountMovesTheSurfaces, ()) {
  const Pose2 mount = *test::any_pose2();
  const auto scan = test::scan_from(test::furnished_room(), {4.0, 3.0, 0.4}, {}, {});
  const auto at_origin = surfaces_of(scan);
  const auto at_mount = surfaces_of(scan, mount);
  // Rounding may tip the thinning at single points; lengths do not change otherwise.
  RC_PRE(at_origin.size() == at_mount.size());
  for (std::size_t i = 0; i < at_origin.size(); ++i) {
    RC_ASSERT(
        (mount * at_origin[i].position.cast<double>().eval() - at_mount[i].position.cast<double>())
            .norm() < 1e-3);
    RC_ASSERT(
        (mount.rotation() * at_origin[i].normal.cast<double>() - at_mount[i].normal.cast<double>())
            .norm() < 1e-2);
  }
}

RC_GTEST_PROP(SurfacePointLaws, NoRangesWhateverBreakIt, ()) {
  const auto values = *rc::gen::container<std::vector<float>>(rc::gen::oneOf(
      rc::gen::element(kNaN, kInf, -kInf, 0.0F, -1.0F, 1e-30F, 3e38F),
      rc::gen::map(test::between(0.0, 12.0), [](double r) { return static_cast<float>(r); })));
  LaserScan scan{.angle_min_rad = -1.0,
                 .angle_increment_rad = *rc::gen::element(0.01, -0.01, 0.0),
                 .range_max_m = 10.0};
  scan.ranges_m = values;
  for (const auto& surface : surfaces_of(scan, {}, {.points_max = 50})) {
    RC_ASSERT(surface.position.allFinite());
    RC_ASSERT(std::abs(surface.normal.norm() - 1.0F) < 1e-4F);
    RC_ASSERT(surface.weight > 0.0F && surface.weight <= 1.0F);
  }
}

}  // namespace
}  // namespace loopstone
