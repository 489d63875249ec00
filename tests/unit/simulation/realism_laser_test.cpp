// Each effect on the laser against the ideal scan.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "loopstone/simulation/surface_index.hpp"
#include "simulation/beam_dropouts.hpp"
#include "simulation/mixed_pixels.hpp"
#include "simulation/range_errors.hpp"
#include "support/simulated_log.hpp"

namespace loopstone {
namespace {

using test::noise_free;
using test::simulate_log;
using test::SimulatedLog;

SimulationOptions clean(double duration_s = 20.0) {
  SimulationOptions options = noise_free({.duration_s = duration_s});
  options.laser.beams = 181;
  options.laser.rate_hz = 5.0;
  return options;
}

SimulationOptions with(const std::string& effects, double duration_s = 20.0) {
  SimulationOptions options = clean(duration_s);
  choose_realism(options.realism, effects);
  return options;
}

bool is_same(float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }

/// The ideal range from a mount at a time of a drive.
double ideal(const SurfaceIndex& index, const Drive& drive, const Pose2& robot_T_lidar,
             double time_s, double angle_rad, double max_range_m) {
  const Pose2 map_T_lidar = drive.pose_at(time_s) * robot_T_lidar;
  const double bearing = map_T_lidar.yaw + angle_rad;
  return index.cast(map_T_lidar.translation(), {std::cos(bearing), std::sin(bearing)}, max_range_m);
}

double fact_of(const SimulatedLog& log, const std::string& name) {
  for (const RealismFact& fact : log.summary.realism.facts) {
    if (fact.name == name) return fact.value;
  }
  ADD_FAILURE() << name << " is not told";
  return 0.0;
}

TEST(RealismBlocked, ARingTravelsWithTheRobotInItsIntervalAndNowhereElse) {
  SimulationOptions options = with("blocked", 30.0);
  options.laser.range_min_m = 0.02;
  options.realism.blocked.at_s = 10.0;
  options.realism.blocked.length_s = 8.0;
  const SimulatedLog log = simulate_log("office", 1, options);
  SimulationOptions without = options;
  without.realism = {};
  const auto blocked = log.scans();
  const auto ideal_scans = simulate_log("office", 1, without).scans();
  ASSERT_EQ(blocked.size(), ideal_scans.size());
  ASSERT_EQ(log.summary.realism.spoils.size(), 1U);
  EXPECT_EQ(log.summary.realism.spoils[0].from_s, 10.0);
  EXPECT_EQ(log.summary.realism.spoils[0].to_s, 18.0);
  std::size_t inside = 0;
  double moved = 0.0;
  for (std::size_t i = 0; i < blocked.size(); ++i) {
    const double time = blocked[i].stamp.seconds() - options.start_s;
    std::size_t ring = 0;
    for (std::size_t beam = 0; beam < blocked[i].ranges_m.size(); ++beam) {
      const float range = blocked[i].ranges_m[beam];
      if (is_same(range, ideal_scans[i].ranges_m[beam])) continue;
      ASSERT_TRUE(time >= 10.0 && time < 18.0) << time;
      ASSERT_GE(range, 0.05f - 1e-6f);
      ASSERT_LE(range, 0.29f + 1e-6f);
      ++ring;
      if (i > 0) moved += std::abs(static_cast<double>(range - blocked[i - 1].ranges_m[beam]));
    }
    if (time < 10.0 || time >= 18.0) continue;
    ++inside;
    EXPECT_GT(ring, 0.9 * static_cast<double>(blocked[i].ranges_m.size()));
  }
  EXPECT_NEAR(static_cast<double>(inside), 40.0, 1.0);
  EXPECT_GT(moved / static_cast<double>(inside), 1.0) << "the same ranges again: no noise";
}

TEST(RealismRange, HasItsBiasScaleAndSpread) {
  RangeErrors errors({.on = true}, Rng(3));
  RealismRecord record;
  errors.note(record);
  ASSERT_EQ(record.facts.size(), 2U);
  const double bias = record.facts[0].value;
  const double scale = record.facts[1].value;
  EXPECT_GE(std::abs(bias), 0.005);
  EXPECT_LE(std::abs(bias), 0.01);
  EXPECT_LE(std::abs(scale - 1.0), 0.003);
  for (const double range : {1.0, 10.0, 30.0}) {
    for (const double tangent : {0.0, 2.0}) {
      double sum = 0.0;
      double squares = 0.0;
      const int count = 20000;
      for (int i = 0; i < count; ++i) {
        const double off = errors.measured(range, tangent) - (scale * range + bias);
        sum += off;
        squares += off * off;
      }
      const double spread = errors.spread_m(range, tangent);
      EXPECT_NEAR(sum / count, 0.0, 0.04 * spread);
      EXPECT_NEAR(std::sqrt(squares / count), spread, 0.03 * spread);
    }
    EXPECT_NEAR(errors.spread_m(range, 0.0), 0.001 * range, 1e-12);
    EXPECT_GT(errors.spread_m(range, 2.0), errors.spread_m(range, 0.0));
  }
}

TEST(RealismRange, TheScansAreOffByIt) {
  SimulationOptions options = with("range");
  options.realism.range = {
      .on = true, .bias_m = 0.05, .scale_error = 0.0, .noise_per_m = 0.0, .beam_width_rad = 0.0};
  const SimulatedLog log = simulate_log("office", 2, options);
  const auto off = log.scans();
  const auto scans = simulate_log("office", 2, clean()).scans();
  const double bias = fact_of(log, "bias_m");
  std::size_t compared = 0;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    for (std::size_t beam = 0; beam < scans[i].ranges_m.size(); ++beam) {
      if (!std::isfinite(off[i].ranges_m[beam]) || !std::isfinite(scans[i].ranges_m[beam]))
        continue;
      EXPECT_NEAR(static_cast<double>(off[i].ranges_m[beam] - scans[i].ranges_m[beam]), bias, 1e-5);
      ++compared;
    }
  }
  EXPECT_GT(compared, 10000U);
}

TEST(RealismMixed, RangesLieBetweenTheNearestAndTheFarthestPart) {
  MixedPixels mixed({.on = true}, Rng(1));
  const BeamEcho near{2.0, 0.0, 1};
  const BeamEcho middle{3.0, 0.0, 2};
  const BeamEcho far{9.0, 0.0, 3};
  bool is_between = false;
  for (int i = 0; i < 200; ++i) {
    const double range = mixed.merged(near, {near, near, middle, middle}).range_m;
    EXPECT_GE(range, 2.0);
    EXPECT_LE(range, 3.0);
    is_between = is_between || (range > 2.1 && range < 2.9);
    // Echoes that do not overlap are told apart.
    const double apart = mixed.merged(near, {near, near, far, far}).range_m;
    EXPECT_TRUE(apart == 2.0 || apart == 9.0) << apart;
    EXPECT_EQ(mixed.merged(middle, {middle, middle, middle, middle}).range_m, 3.0);
  }
  EXPECT_TRUE(is_between);
}

TEST(RealismMixed, OnlyBeamsAtEdgesDiffer) {
  const auto mixed = simulate_log("office", 2, with("mixed")).scans();
  const auto scans = simulate_log("office", 2, clean()).scans();
  std::size_t differ = 0;
  std::size_t beams = 0;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    for (std::size_t beam = 1; beam + 1 < scans[i].ranges_m.size(); ++beam) {
      ++beams;
      if (is_same(scans[i].ranges_m[beam], mixed[i].ranges_m[beam])) continue;
      ++differ;
    }
  }
  EXPECT_GT(differ, beams / 500);
  EXPECT_LT(differ, beams / 8);
}

TEST(RealismDropouts, GrazingAndDarkSurfacesLoseMore) {
  const BeamDropouts dropouts({.on = true, .share = 0.01, .dark_share = 0.0}, Rng(1));
  const double square_on = dropouts.chance_of({5.0, 0.0, 1});
  EXPECT_NEAR(square_on, 0.01, 1e-12);
  EXPECT_NEAR(dropouts.chance_of({5.0, std::tan(1.2), 1}), 0.01, 1e-12);
  EXPECT_GT(dropouts.chance_of({5.0, std::tan(1.45), 1}), 0.4);
  EXPECT_GT(dropouts.chance_of({5.0, 1e9, 1}), 0.999);
  const BeamDropouts dark({.on = true, .share = 0.0, .dark_share = 1.0, .dark_reach_m = 4.0},
                          Rng(1));
  EXPECT_NEAR(dark.chance_of({4.0, 0.0, 1}), 0.5, 1e-12);
  EXPECT_LT(dark.chance_of({1.0, 0.0, 1}), dark.chance_of({8.0, 0.0, 1}));
  EXPECT_EQ(dark.chance_of({8.0, 0.0, SurfaceHit::kNothing}), 0.0) << "a person is no dark wall";
}

TEST(RealismDropouts, LostBeamsAreFreeOrBadByTheirShare) {
  BeamDropouts dropouts({.on = true, .share = 0.3, .dark_share = 0.0, .seen_as_free = 0.25},
                        Rng(2));
  int free = 0;
  int bad = 0;
  const int count = 20000;
  for (int i = 0; i < count; ++i) {
    const double range = dropouts.measured(5.0, {5.0, 0.0, 1});
    free += std::isinf(range) ? 1 : 0;
    bad += std::isnan(range) ? 1 : 0;
  }
  EXPECT_NEAR(free, 0.075 * count, 0.01 * count);
  EXPECT_NEAR(bad, 0.225 * count, 0.015 * count);
}

TEST(RealismSteps, RangesAreWholeSteps) {
  const auto stepped = simulate_log("office", 2, with("steps")).scans();
  const auto scans = simulate_log("office", 2, clean()).scans();
  for (std::size_t i = 0; i < scans.size(); ++i) {
    for (std::size_t beam = 0; beam < scans[i].ranges_m.size(); ++beam) {
      const auto range = static_cast<double>(stepped[i].ranges_m[beam]);
      if (!std::isfinite(range)) continue;
      EXPECT_NEAR(range, 0.01 * std::round(100.0 * range), 1e-5);
      EXPECT_NEAR(range, static_cast<double>(scans[i].ranges_m[beam]), 0.00501);
    }
  }
}

TEST(RealismSweep, BeamsLeaveDuringTheSweepAndTheLogSaysNothingOfIt) {
  SimulationOptions options = with("sweep", 40.0);
  options.realism.sweep.sweep_s = 0.1;
  const SimulatedLog log = simulate_log("office", 2, options);
  Drive drive = drive_route(log.world, log.robot.footprint_radius_m, options.drive);
  drive.cut(options.duration_s);
  const SurfaceIndex index(log.world.plan);
  const Pose2& mount = log.robot.lidars.front().robot_T_lidar;
  double most_turned = 0.0;
  for (const LaserScan& scan : log.scans()) {
    EXPECT_EQ(scan.time_increment_s, 0.0);
    const double time = scan.stamp.seconds() - options.start_s;
    most_turned =
        std::max(most_turned, std::abs(drive.turned_rad(time + 0.1) - drive.turned_rad(time)));
    for (std::size_t beam = 0; beam < scan.ranges_m.size(); ++beam) {
      if (!std::isfinite(scan.ranges_m[beam])) continue;
      const double beam_s = time + 0.1 * static_cast<double>(beam) / 180.0;
      const double range =
          ideal(index, drive, mount, beam_s, scan.angle_rad(beam), scan.range_max_m);
      EXPECT_NEAR(static_cast<double>(scan.ranges_m[beam]), range, 1e-6 * range + 1e-6);
    }
  }
  EXPECT_GT(most_turned, 0.03) << "the robot did not turn: this test shows nothing";
}

TEST(RealismMount, ScansAreTakenFromTheTrueMount) {
  const SimulatedLog log = simulate_log("office", 4, with("mount"));
  const Pose2 truth{fact_of(log, "robot_T_lidar_x_m"), fact_of(log, "robot_T_lidar_y_m"),
                    fact_of(log, "robot_T_lidar_yaw_rad")};
  const Pose2& told = log.robot.lidars.front().robot_T_lidar;
  EXPECT_GE(std::abs(truth.yaw - told.yaw), 0.0175);
  EXPECT_LE(std::abs(truth.yaw - told.yaw), 0.035);
  EXPECT_GE(std::abs(truth.y - told.y), 0.015);
  const Drive drive = drive_route(log.world, log.robot.footprint_radius_m, {});
  const SurfaceIndex index(log.world.plan);
  for (const LaserScan& scan : log.scans()) {
    EXPECT_FALSE(scan.robot_T_lidar) << "the log must not tell";
    for (std::size_t beam = 0; beam < scan.ranges_m.size(); beam += 7) {
      if (!std::isfinite(scan.ranges_m[beam])) continue;
      const double beam_s =
          scan.stamp.seconds() - 1000.0 + static_cast<double>(beam) * scan.time_increment_s;
      const double range =
          ideal(index, drive, truth, beam_s, scan.angle_rad(beam), scan.range_max_m);
      EXPECT_NEAR(static_cast<double>(scan.ranges_m[beam]), range, 1e-6 * range + 1e-6);
    }
  }
}

TEST(RealismDirty, OnlyItsSectorIsSpoilt) {
  const SimulationOptions options = with("dirty");
  const auto dirty = simulate_log("office", 2, options).scans();
  const auto scans = simulate_log("office", 2, clean()).scans();
  std::size_t spoilt = 0;
  std::size_t in_sector = 0;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    for (std::size_t beam = 0; beam < scans[i].ranges_m.size(); ++beam) {
      const double off = std::abs(scans[i].angle_rad(beam) - options.realism.dirty.middle_rad);
      const bool is_in = off <= 0.5 * options.realism.dirty.width_rad;
      in_sector += is_in ? 1 : 0;
      if (is_same(scans[i].ranges_m[beam], dirty[i].ranges_m[beam])) continue;
      ++spoilt;
      EXPECT_TRUE(is_in);
      EXPECT_TRUE(!std::isfinite(dirty[i].ranges_m[beam]) || dirty[i].ranges_m[beam] <= 0.3f);
    }
  }
  EXPECT_NEAR(static_cast<double>(spoilt) / static_cast<double>(in_sector), 0.7, 0.03);
}

TEST(RealismUpsideDown, LeftIsRight) {
  SimulationOptions options = clean(3.0);  // it stands
  options.laser.sweep_s = 0.0;
  const auto scans = simulate_log("office", 2, options).scans();
  options.realism.upside_down.on = true;
  const auto mirrored = simulate_log("office", 2, options).scans();
  ASSERT_GT(scans.size(), 5U);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    std::vector<float> turned = mirrored[i].ranges_m;
    std::reverse(turned.begin(), turned.end());
    for (std::size_t beam = 0; beam < turned.size(); ++beam) {
      if (!std::isfinite(turned[beam])) continue;
      EXPECT_NEAR(turned[beam], scans[i].ranges_m[beam], 1e-4f * turned[beam]);
    }
    EXPECT_NE(mirrored[i].ranges_m, scans[i].ranges_m);
  }
}

}  // namespace
}  // namespace loopstone
