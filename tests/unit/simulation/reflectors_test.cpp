#include "loopstone/sensor/reflectors.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <variant>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/simulation/place_reflectors.hpp"
#include "loopstone/simulation/simulate.hpp"
#include "loopstone/simulation/surface_index.hpp"
#include "simulation/reflectivity.hpp"

namespace loopstone {
namespace {

constexpr double kRobotRadiusM = 0.25;

World lit_office(int count = 60, std::uint64_t seed = 1) {
  return with_reflectors(make_world("office", 1), kRobotRadiusM, {}, count, seed);
}

TEST(PlaceReflectors, TheyHangOnWallsOrStandBeforeThemApart) {
  const World bare = make_world("office", 1);
  const World world = lit_office();
  ASSERT_EQ(world.reflectors.size(), 60U);
  const SurfaceIndex surfaces(bare.plan);
  int posts = 0;
  for (std::size_t i = 0; i < world.reflectors.size(); ++i) {
    const Reflector& reflector = world.reflectors[i];
    EXPECT_EQ(reflector.id, static_cast<int>(i) + 1);
    if (reflector.radius_m == 0.0) {
      EXPECT_LT(surfaces.distance(reflector.centre, 1.0), 1e-6);
      EXPECT_NEAR(reflector.normal.norm(), 1.0, 1e-12);
      // Its front is free.
      const Eigen::Vector2d before = reflector.centre + 0.02 * reflector.normal;
      EXPECT_NEAR(surfaces.distance(before, 1.0), 0.02, 1e-6);
    } else {
      ++posts;
    }
    for (std::size_t k = 0; k < i; ++k) {
      EXPECT_GT((world.reflectors[k].centre - reflector.centre).norm(), 0.85);
    }
  }
  EXPECT_GE(posts, 10);
  EXPECT_GT(world.plan.circles.size(), bare.plan.circles.size());
}

TEST(PlaceReflectors, TheSameSeedGivesTheSamePlaces) {
  const World one = lit_office(20);
  const World other = lit_office(20);
  const World another = lit_office(20, 2);
  ASSERT_EQ(one.reflectors.size(), other.reflectors.size());
  bool differs = false;
  for (std::size_t i = 0; i < one.reflectors.size(); ++i) {
    EXPECT_EQ(one.reflectors[i].centre, other.reflectors[i].centre);
    differs = differs || one.reflectors[i].centre != another.reflectors[i].centre;
  }
  EXPECT_TRUE(differs);
}

TEST(Reflectivity, ReflectorsGleamFromTheFrontAlone) {
  const Reflector strip{
      .id = 1, .centre = {5.0, 0.0}, .normal = {-1.0, 0.0}, .width_m = 0.1, .radius_m = 0.0};
  Reflectivity gleam({strip}, Rng(1));
  const auto mean = [&](double bearing_rad, double range_m) {
    double sum = 0.0;
    for (int i = 0; i < 200; ++i) {
      sum += static_cast<double>(gleam.intensity({0.0, 0.0}, bearing_rad, range_m));
    }
    return sum / 200.0;
  };
  const double faded = 1.0 / (1.0 + 0.25);
  EXPECT_NEAR(mean(0.0, 5.0), 3000.0 * faded, 100.0);
  EXPECT_NEAR(mean(0.02, 5.001), 300.0 * faded, 10.0) << "beside it";
  EXPECT_NEAR(mean(0.0, 4.0), 300.0 / 1.16, 10.0) << "something before it";
  EXPECT_EQ(gleam.intensity({0.0, 0.0}, 0.0, std::nan("")), 0.0F);
  Reflectivity behind({strip}, Rng(1));
  EXPECT_LT(behind.intensity({10.0, 0.0}, kPi, 5.0), 600.0F);
}

struct Scans {
  std::vector<LaserScan> scans{};
  std::vector<Pose2> truth{};
};

Scans driven(const World& world, double noise_m) {
  SimulationOptions options;
  options.duration_s = 20.0;
  options.laser.noise_m = noise_m;
  options.laser.rate_hz = 2.0;
  options.laser.sweep_s = 0.0;
  options.laser.clock_offset_s = 0.0;
  Scans driven;
  simulate(world, RobotModel{}, options, 1,
           {.message =
                [&](SensorMessage message) {
                  if (auto* scan = std::get_if<LaserScan>(&message)) driven.scans.push_back(*scan);
                },
            .truth = [&](const StampedPose2& pose) { driven.truth.push_back(pose.pose); }});
  return driven;
}

TEST(SimulatedReflectors, AreFoundWhereTheyAre) {
  const World world = lit_office(120);
  const Scans log = driven(world, 0.005);
  ASSERT_EQ(log.scans.size(), log.truth.size());
  int seen = 0;
  double squares = 0.0;
  for (std::size_t i = 0; i < log.scans.size(); ++i) {
    const auto found =
        find_reflectors(log.scans[i], LidarMount{}.robot_T_lidar, Tangent2::Zero(), {});
    for (const LandmarkObservation& observation : found) {
      double nearest = 1e9;
      for (const Reflector& reflector : world.reflectors) {
        const Eigen::Vector2d centre = log.truth[i] * centre_of(observation, reflector.radius_m);
        nearest = std::min(nearest, (centre - reflector.centre).norm());
      }
      EXPECT_LT(nearest, 0.1) << "scan " << i;
      squares += nearest * nearest;
      ++seen;
    }
  }
  ASSERT_GT(seen, 100);
  EXPECT_LT(std::sqrt(squares / seen), 0.015);
}

TEST(SimulatedReflectors, ChangeNoRangeButThoseOfPosts) {
  World flat = lit_office(3);  // the fourth would be a post
  const Scans lit = driven(flat, 0.01);
  flat.reflectors.clear();
  const Scans dark = driven(flat, 0.01);
  ASSERT_EQ(lit.scans.size(), dark.scans.size());
  for (std::size_t i = 0; i < lit.scans.size(); ++i) {
    EXPECT_EQ(lit.scans[i].intensities.size(), lit.scans[i].ranges_m.size());
    EXPECT_TRUE(dark.scans[i].intensities.empty());
    for (std::size_t beam = 0; beam < lit.scans[i].ranges_m.size(); ++beam) {
      const float a = lit.scans[i].ranges_m[beam];
      const float b = dark.scans[i].ranges_m[beam];
      ASSERT_TRUE(a == b || (std::isnan(a) && std::isnan(b)));
    }
  }
}

}  // namespace
}  // namespace loopstone
