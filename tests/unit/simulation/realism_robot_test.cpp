// Each effect on stamps, messages, wheels, gyro and the drive.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "loopstone/simulation/surface_index.hpp"
#include "loopstone/simulation/world.hpp"
#include "simulation/message_faults.hpp"
#include "simulation/uneven_floor.hpp"
#include "simulation/wheel_slips.hpp"
#include "support/simulated_log.hpp"

namespace loopstone {
namespace {

using test::noise_free;
using test::simulate_log;
using test::SimulatedLog;

SimulationOptions with(const std::string& effects, double duration_s, bool poses = false) {
  SimulationOptions options = noise_free({.duration_s = duration_s, .odometry_poses = poses});
  options.laser.beams = 31;
  options.laser.rate_hz = 5.0;
  choose_realism(options.realism, effects);
  return options;
}

double fact_of(const SimulatedLog& log, const std::string& effect, const std::string& name) {
  for (const RealismFact& fact : log.summary.realism.facts) {
    if (fact.effect == effect && fact.name == name) return fact.value;
  }
  ADD_FAILURE() << name << " is not told";
  return 0.0;
}

TEST(RealismStamps, AreLateAndShakyAndNeverGoBack) {
  const RealismStamps options{
      .on = true, .jitter_s = 0.004, .latency_s = 0.03, .late_share = 0.0, .drift_ppm = 0.0};
  StampErrors stamps(options, 0.03, 1e-4, Rng(1));
  double sum = 0.0;
  double squares = 0.0;
  double last = -1.0;
  const int count = 20000;
  for (int i = 0; i < count; ++i) {
    const double time = 0.1 * i;
    const double stamp = stamps.stamp_s(time);
    EXPECT_GT(stamp, last);
    last = stamp;
    const double off = stamp - 1.0001 * time - 0.03;
    sum += off;
    squares += off * off;
  }
  EXPECT_NEAR(sum / count, 0.0, 1e-4);
  EXPECT_NEAR(std::sqrt(squares / count), 0.004, 1e-4);
}

TEST(RealismStamps, JitterBeyondThePeriodKeepsTheOrder) {
  StampErrors stamps({.on = true, .jitter_s = 0.5}, 0.0, 0.0, Rng(1));
  double last = -10.0;
  for (int i = 0; i < 1000; ++i) {
    const double stamp = stamps.stamp_s(0.01 * i);
    EXPECT_GT(stamp, last);
    last = stamp;
  }
}

TEST(RealismStamps, TruthIsThePoseAtTheTimeOfTheScanWithTheStampOfTheLog) {
  const SimulatedLog exact = simulate_log("office", 6, with("none", 20.0));
  const SimulatedLog shaky = simulate_log("office", 6, with("stamps", 20.0));
  const std::size_t count = std::min(exact.truth.size(), shaky.truth.size());
  ASSERT_GE(count + 2, exact.truth.size());
  double most = 0.0;
  const auto scans = shaky.scans();
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(exact.truth.poses()[i].pose, shaky.truth.poses()[i].pose);
    EXPECT_EQ(shaky.truth.poses()[i].stamp, scans[i].stamp);
    most = std::max(
        most,
        std::abs((shaky.truth.poses()[i].stamp - exact.truth.poses()[i].stamp).seconds() - 0.03));
  }
  EXPECT_GT(most, 0.005);
  EXPECT_LT(most, 0.25);
}

TEST(RealismLoss, BurstsTakeScansAndOdometryAndAreTold) {
  SimulationOptions options = with("loss", 60.0);
  options.realism.loss = {.on = true, .share = 0.0, .every_s = 10.0, .longest_s = 3.0};
  const SimulatedLog log = simulate_log("office", 6, options);
  const SimulatedLog whole = simulate_log("office", 6, with("none", 60.0));
  ASSERT_FALSE(log.summary.realism.spoils.empty());
  const auto is_told = [&](Stamp stamp) {
    const double time = stamp.seconds() - 1000.0;
    return std::ranges::any_of(log.summary.realism.spoils, [&](const RealismSpoil& spoil) {
      return time >= spoil.from_s && time < spoil.to_s;
    });
  };
  for (const SensorMessage& message : log.messages) EXPECT_FALSE(is_told(stamp_of(message)));
  std::size_t lost = 0;
  for (const SensorMessage& message : whole.messages) lost += is_told(stamp_of(message)) ? 1 : 0;
  EXPECT_GT(lost, 100U);
  EXPECT_EQ(log.messages.size() + lost, whole.messages.size());
}

TEST(RealismWheels, SlipsAddUpToWhatTheyAre) {
  WheelSlips slips({.on = true, .slip_every_m = 5.0, .slip_m = 0.1, .slip_rad = 0.2}, Rng(1));
  double ahead = 0.0;
  double most = 0.0;
  for (int i = 1; i <= 100000; ++i) {
    const WheelSlips::Slip slip = slips.since(0.025 * i, 0.01 * i);
    EXPECT_GE(slip.ahead_m, 0.0);
    ahead += slip.ahead_m;
    most = std::max(most, slip.ahead_m);
  }
  // 1 km with a slip of 6 cm every 5 m on the average.
  EXPECT_NEAR(ahead, 12.0, 1.5);
  EXPECT_LE(most, 0.1 * 0.025 / 0.5 + 1e-9);
}

TEST(RealismWheels, DistancesAreOffByTheirScale) {
  SimulationOptions options = with("wheels", 60.0, true);
  options.realism.wheels.slip_m = 0.0;
  options.realism.wheels.slip_rad = 0.0;
  options.realism.wheels.imbalance = 0.0;
  const SimulatedLog log = simulate_log("office", 6, options);
  const SimulatedLog exact = simulate_log("office", 6, with("none", 60.0, true));
  const auto way_of = [](const SimulatedLog& from) {
    double way = 0.0;
    Pose2 last;
    for (const SensorMessage& message : from.messages) {
      const auto* odometry = std::get_if<OdometryPose>(&message);
      if (odometry == nullptr) continue;
      way += (last.inverse() * odometry->odom_T_robot).x;
      last = odometry->odom_T_robot;
    }
    return way;
  };
  const double scale = fact_of(log, "wheels", "left_scale");
  EXPECT_GE(std::abs(scale - 1.0), 0.009);
  EXPECT_NEAR(way_of(log) / way_of(exact), scale, 0.001);
}

TEST(RealismGyro, ItsRateIsOffByItsScaleAndBias) {
  const SimulatedLog log = simulate_log("office", 6, with("gyro", 40.0));
  const SimulatedLog exact = simulate_log("office", 6, with("none", 40.0));
  const double scale = fact_of(log, "gyro", "scale");
  const double bias = fact_of(log, "gyro", "bias_rad_s");
  EXPECT_GE(std::abs(scale - 1.0), 0.01);
  ASSERT_EQ(log.messages.size(), exact.messages.size());
  for (std::size_t i = 0; i < log.messages.size(); ++i) {
    const auto* imu = std::get_if<ImuSample>(&log.messages[i]);
    if (imu == nullptr) continue;
    const double rate = std::get<ImuSample>(exact.messages[i]).angular_velocity_rad_s.z();
    EXPECT_NEAR(imu->angular_velocity_rad_s.z(), scale * rate + bias, 1e-12);
  }
}

TEST(RealismRolling, TheLogBeginsWhileTheRobotDrives) {
  const SimulatedLog log = simulate_log("office", 6, with("rolling", 10.0));
  const auto& poses = log.truth.poses();
  const double first_s = (poses[5].stamp - poses[0].stamp).seconds();
  const Pose2 moved = poses[0].pose.inverse() * poses[5].pose;
  EXPECT_GT((moved.translation().norm() + std::abs(moved.yaw)) / first_s, 0.2);
  EXPECT_NEAR(poses[0].stamp.seconds(), 1000.0, 0.5);
}

TEST(RealismCarried, WheelsStandWhileTheRobotIsMoved) {
  SimulationOptions options = with("carried", 60.0, true);
  options.realism.carried.at_s = 30.0;
  const SimulatedLog log = simulate_log("office", 6, options);
  ASSERT_EQ(log.summary.realism.spoils.size(), 1U);
  const RealismSpoil& lift = log.summary.realism.spoils[0];
  EXPECT_NEAR(lift.from_s, 30.0, 0.03);
  EXPECT_NEAR(lift.to_s, 34.0, 0.03);
  const auto at = [&](double time_s) {
    return log.truth.at_clamped(Stamp::from_seconds(1000.0 + time_s)).value();
  };
  const Pose2 carried = at(lift.from_s).inverse() * at(lift.to_s);
  EXPECT_NEAR(carried.translation().norm(), 3.0, 0.2);
  EXPECT_NEAR(std::abs(carried.yaw), 1.0, 0.05);
  EXPECT_NEAR(fact_of(log, "carried", "distance_m"), 3.0, 0.2);
  EXPECT_NEAR(std::abs(fact_of(log, "carried", "turn_rad")), 1.0, 1e-6);
  Trajectory odometry;
  for (const SensorMessage& message : log.messages) {
    const auto* pose = std::get_if<OdometryPose>(&message);
    if (pose == nullptr) continue;
    if (!odometry.empty() && odometry.back().stamp >= pose->stamp) continue;
    odometry.append(pose->stamp, pose->odom_T_robot);
  }
  const auto odometry_at = [&](double time_s) {
    return odometry.at_clamped(Stamp::from_seconds(1000.0 + time_s)).value();
  };
  const Pose2 seen = odometry_at(lift.from_s + 0.1).inverse() * odometry_at(lift.to_s - 0.1);
  EXPECT_LT(seen.translation().norm(), 0.01);
  EXPECT_LT(std::abs(seen.yaw), 0.01);
  EXPECT_GT((at(58.0).translation() - at(36.0).translation()).norm(), 1.0) << "it goes on";
  EXPECT_EQ(log.truth.size(), 300U) << "scans come all the time";
}

TEST(RealismCarried, HandsGoRoundWallsAndThroughDoors) {
  SimulationOptions options = with("carried", 36.0);
  options.realism.carried.at_s = 30.0;
  double farthest_m = 0.0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const World world = make_world("office", seed);
    const SurfaceIndex walls(world.plan);
    const SimulatedLog log = simulate_log("office", seed, options);
    const RealismSpoil& lift = log.summary.realism.spoils.at(0);
    for (double time_s = lift.from_s; time_s <= lift.to_s; time_s += 0.05) {
      const Pose2 at = log.truth.at_clamped(Stamp::from_seconds(1000.0 + time_s)).value();
      EXPECT_GT(walls.distance(at.translation(), 1.0), 0.15) << "seed " << seed << ", " << time_s;
    }
    farthest_m = std::max(farthest_m, fact_of(log, "carried", "distance_m"));
  }
  EXPECT_GT(farthest_m, 2.8);
}

TEST(RealismCarried, TheGyroFeelsTheHands) {
  SimulationOptions options = with("carried", 40.0);
  options.realism.carried.at_s = 30.0;
  double turned = 0.0;
  const SimulatedLog log = simulate_log("office", 6, options);
  const RealismSpoil& lift = log.summary.realism.spoils.at(0);
  for (const SensorMessage& message : log.messages) {
    const auto* imu = std::get_if<ImuSample>(&message);
    if (imu == nullptr) continue;
    const double time = imu->stamp.seconds() - 1000.0;
    if (time >= lift.from_s && time < lift.to_s)
      turned += imu->angular_velocity_rad_s.z() / options.imu.rate_hz;
  }
  EXPECT_NEAR(std::abs(turned), 1.0, 0.02);
}

TEST(RealismCarried, BlindNoScansComeMeanwhile) {
  SimulationOptions options = with("carried_blind", 60.0);
  options.realism.carried_blind.at_s = 30.0;
  const SimulatedLog log = simulate_log("office", 6, options);
  const RealismSpoil& lift = log.summary.realism.spoils.at(0);
  EXPECT_EQ(lift.effect, "carried_blind");
  double longest = 0.0;
  Stamp last = log.scans().front().stamp;
  for (const LaserScan& scan : log.scans()) {
    const double time = scan.stamp.seconds() - 1000.0;
    EXPECT_FALSE(time >= lift.from_s && time < lift.to_s);
    longest = std::max(longest, (scan.stamp - last).seconds());
    last = scan.stamp;
  }
  EXPECT_NEAR(longest, 4.1, 0.2);
}

TEST(RealismUneven, LevelGroundChangesNothing) {
  const UnevenFloor level({.on = true, .slope_rad = 0.0, .sill_m = 0.0, .ramp_rad = 0.0}, Rng(1));
  const FloorTilt tilt = level.tilt_at({3.0, 4.0, 0.5});
  EXPECT_EQ(tilt.nose_up_rad, 0.0);
  EXPECT_EQ(tilt.left_up_rad, 0.0);
  EXPECT_EQ(level.range_m(7.0, 0.3, 0.5, tilt), 7.0);
}

TEST(RealismUneven, LeaningBeamsMeetTheFloorOrTheCeiling) {
  const UnevenFloor floor({.on = true, .ceiling_m = 2.5}, Rng(1));
  const double infinity = std::numeric_limits<double>::infinity();
  const FloorTilt nose_down{-0.05, 0.0};
  EXPECT_NEAR(floor.range_m(infinity, 0.0, 0.5, nose_down), 0.5 / std::sin(0.05), 1e-9);
  EXPECT_NEAR(floor.range_m(3.0, 0.0, 0.5, nose_down), 3.0 / std::cos(0.05), 1e-9);
  EXPECT_NEAR(floor.range_m(infinity, kPi, 0.5, nose_down), 2.0 / std::sin(0.05), 1e-9);
  EXPECT_EQ(floor.range_m(infinity, 0.5 * kPi, 0.5, nose_down), infinity);
  EXPECT_NEAR(floor.range_m(infinity, -0.5 * kPi, 0.5, {0.0, 0.05}), 0.5 / std::sin(0.05), 1e-9);
}

TEST(RealismUneven, WavesHaveTheSlopeThatWasAskedFor) {
  double squares = 0.0;
  double count = 0.0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const UnevenFloor floor({.on = true, .slope_rad = 0.01, .sill_m = 0.0, .ramp_rad = 0.0},
                            Rng(seed));
    for (int i = 0; i < 500; ++i) {
      const FloorTilt tilt = floor.tilt_at({0.31 * i, 0.17 * i, 0.1 * i});
      squares += tilt.nose_up_rad * tilt.nose_up_rad;
      count += 1.0;
    }
  }
  EXPECT_NEAR(std::sqrt(squares / count), 0.01, 0.0015);
}

TEST(RealismUneven, RampsGoUpAndDownAtTheirSlope) {
  const UnevenFloor floor({.on = true, .slope_rad = 0.0, .sill_m = 0.0, .ramp_rad = 0.06}, Rng(2));
  double up = 0.0;
  double down = 0.0;
  for (double x = 0.0; x < 120.0; x += 0.05) {
    const FloorTilt tilt = floor.tilt_at({x, 0.0, 0.0});
    EXPECT_NEAR(tilt.left_up_rad, floor.tilt_at({0.0, 0.0, 0.0}).left_up_rad, 1e-9);
    up += tilt.nose_up_rad > 0.059 ? 0.05 : 0.0;
    down += tilt.nose_up_rad < -0.059 ? 0.05 : 0.0;
    EXPECT_LE(std::abs(tilt.nose_up_rad), 0.06 + 1e-9);
  }
  // Ramps of 3 m, less the wheelbase on both of their ends.
  EXPECT_NEAR(up, 2.65, 0.11);
  EXPECT_NEAR(down, 2.65, 0.11);
}

TEST(RealismUneven, ASillLiftsTheFrontThenTheRear) {
  const UnevenFloor floor({.on = true, .slope_rad = 0.0, .sill_m = 0.02, .ramp_rad = 0.0}, Rng(1));
  double highest = 0.0;
  double lowest = 0.0;
  for (double x = 0.0; x < 9.0; x += 0.01) {
    const double up = floor.tilt_at({x, 4.4, 0.0}).nose_up_rad;
    highest = std::max(highest, up);
    lowest = std::min(lowest, up);
  }
  EXPECT_NEAR(highest, 0.02 / 0.35, 0.012);
  EXPECT_NEAR(lowest, -0.02 / 0.35, 0.012);
}

}  // namespace
}  // namespace loopstone
