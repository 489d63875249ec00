#include "loopstone/simulation/simulate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/simulation/surface_index.hpp"
#include "support/simulated_log.hpp"

namespace loopstone {
namespace {

using test::noise_free;
using test::simulate_log;
using test::SimulatedLog;

SimulationOptions short_run(double duration_s) {
  SimulationOptions options;
  options.duration_s = duration_s;
  options.laser.beams = 181;
  return options;
}

/// The drive that simulate() makes.
Drive drive_of(const SimulatedLog& log, const SimulationOptions& options) {
  Drive drive = drive_route(log.world, log.robot.footprint_radius_m, options.drive);
  drive.cut(options.duration_s);
  return drive;
}

TEST(Simulate, MessagesComeInTimeOrderAtTheirRates) {
  const SimulationOptions options = short_run(30.0);
  const SimulatedLog log = simulate_log("office", 1, options);
  std::array<int, 3> counts{};
  Stamp last{0};
  for (const SensorMessage& message : log.messages) {
    EXPECT_LE(last, stamp_of(message));
    last = stamp_of(message);
    if (std::holds_alternative<WheelTicks>(message)) ++counts[0];
    if (std::holds_alternative<ImuSample>(message)) ++counts[1];
    if (std::holds_alternative<LaserScan>(message)) ++counts[2];
  }
  EXPECT_NEAR(counts[0], 40 * 30, 2);
  EXPECT_NEAR(counts[1], 100 * 30, 2);
  EXPECT_NEAR(counts[2], 10 * 30, 2);
  EXPECT_EQ(log.summary.scans, counts[2]);
  EXPECT_EQ(log.truth.size(), static_cast<std::size_t>(counts[2]));
  EXPECT_EQ(log.summary.messages, static_cast<std::int64_t>(log.messages.size()));
}

TEST(Simulate, ScansWithoutNoiseAreTheRangesFromTheTruePosesOfTheirBeams) {
  SimulationOptions options = noise_free(short_run(60.0));
  options.laser.rate_hz = 2.0;
  options.laser.sweep_s =
      0.05;  // so slow that a scan taken from one pose would differ by centimetres
  const SimulatedLog log = simulate_log("office", 2, options);
  const Drive drive = drive_of(log, options);
  const SurfaceIndex index(log.world.plan);
  double most_moved = 0.0;
  for (const LaserScan& scan : log.scans()) {
    const auto map_T_robot = log.truth.nearest(scan.stamp, Duration{0});
    ASSERT_TRUE(map_T_robot);
    const double time = scan.stamp.seconds() - options.start_s;
    EXPECT_NEAR((map_T_robot->translation() - drive.pose_at(time).translation()).norm(), 0.0, 1e-9);
    for (std::size_t beam = 0; beam < scan.ranges_m.size(); ++beam) {
      const double beam_time = time + static_cast<double>(beam) * scan.time_increment_s;
      const Pose2 map_T_lidar = drive.pose_at(beam_time) * log.robot.lidars.front().robot_T_lidar;
      const double yaw = map_T_lidar.yaw + scan.angle_rad(beam);
      const Eigen::Vector2d direction(std::cos(yaw), std::sin(yaw));
      const double range = index.cast(map_T_lidar.translation(), direction, scan.range_max_m);
      if (std::isnan(scan.ranges_m[beam])) {
        EXPECT_LT(range, scan.range_min_m);
        continue;
      }
      if (std::isinf(range)) {
        EXPECT_EQ(static_cast<double>(scan.ranges_m[beam]), range);
        continue;
      }
      // A range is a float, which rounds by up to 6e-8 of it.
      EXPECT_NEAR(static_cast<double>(scan.ranges_m[beam]), range, 1e-7 * range + 1e-9)
          << "beam " << beam;
    }
    most_moved =
        std::max(most_moved,
                 (drive.pose_at(time).inverse() * drive.pose_at(time + 0.05)).translation().norm());
  }
  EXPECT_GT(most_moved, 0.02) << "the robot stood still: this test shows nothing";
}

TEST(Simulate, RangesHaveTheNoiseThatWasAskedFor) {
  SimulationOptions options = short_run(20.0);
  options.laser.dropout_probability = 0.05;
  const SimulatedLog noisy = simulate_log("office", 3, options);
  options.laser.noise_m = 0.0;
  options.laser.dropout_probability = 0.0;
  const SimulatedLog clean = simulate_log("office", 3, options);
  double sum = 0.0;
  double squares = 0.0;
  double count = 0.0;
  double dropped = 0.0;
  const auto noisy_scans = noisy.scans();
  const auto clean_scans = clean.scans();
  ASSERT_EQ(noisy_scans.size(), clean_scans.size());
  for (std::size_t i = 0; i < noisy_scans.size(); ++i) {
    for (std::size_t beam = 0; beam < noisy_scans[i].ranges_m.size(); ++beam) {
      const auto range = static_cast<double>(clean_scans[i].ranges_m[beam]);
      const double error = static_cast<double>(noisy_scans[i].ranges_m[beam]) - range;
      if (std::isnan(error)) {
        dropped += 1.0;
        continue;
      }
      sum += error;
      squares += error * error;
      count += 1.0;
    }
  }
  EXPECT_NEAR(sum / count, 0.0, 0.0003);
  EXPECT_NEAR(std::sqrt(squares / count), 0.01, 0.0003);
  EXPECT_NEAR(dropped / (count + dropped), 0.05, 0.005);
}

TEST(Simulate, NothingInRangeIsInfiniteAndTooNearIsBad) {
  SimulationOptions options = noise_free(short_run(10.0));
  options.laser.range_max_m = 3.0;
  options.laser.range_min_m = 1.5;
  int infinite = 0;
  int bad = 0;
  for (const LaserScan& scan : simulate_log("corridor", 1, options).scans()) {
    for (const float range : scan.ranges_m) {
      if (std::isinf(range)) {
        EXPECT_GT(range, 0.0f);
        ++infinite;
      } else if (std::isnan(range)) {
        ++bad;
      } else {
        EXPECT_GE(range, 1.5f);
        EXPECT_LE(range, 3.0f);
      }
    }
  }
  EXPECT_GT(infinite, 100);
  EXPECT_GT(bad, 100);
}

TEST(Simulate, CountsWithoutNoiseAddUpToThePath) {
  const SimulationOptions options = noise_free(short_run(90.0));
  const SimulatedLog log = simulate_log("office", 4, options);
  const Drive drive = drive_of(log, options);
  const WheelModel& wheels = log.robot.wheels;
  std::array<std::int64_t, 4> total{};
  Stamp last{};
  for (const SensorMessage& message : log.messages) {
    const auto* ticks = std::get_if<WheelTicks>(&message);
    if (ticks == nullptr) continue;
    for (std::size_t wheel = 0; wheel < 4; ++wheel) total[wheel] += ticks->counts[wheel];
    last = ticks->stamp;
    // A fraction of a count is carried on, never lost: after any time each sum is right to one
    // count.
    const double time = ticks->stamp.seconds() - options.start_s;
    const double aside = 0.5 * wheels.track_width_m * drive.turned_rad(time);
    const double right = (drive.travelled_m(time) + aside) / wheels.metres_per_count;
    const double left = (drive.travelled_m(time) - aside) / wheels.metres_per_count;
    for (const std::size_t wheel : {0U, 2U})
      EXPECT_NEAR(static_cast<double>(total[wheel]), right - 0.5, 0.51);
    for (const std::size_t wheel : {1U, 3U})
      EXPECT_NEAR(static_cast<double>(total[wheel]), left - 0.5, 0.51);
  }
  EXPECT_GT(last.seconds() - options.start_s, 89.0);
  EXPECT_GT(drive.travelled_m(90.0), 30.0);
}

TEST(Simulate, CumulativeCountersWrap) {
  SimulationOptions options = short_run(40.0);
  RobotModel robot;
  robot.wheels.counts_are_cumulative = true;
  robot.wheels.counter_bits = 12;
  const SimulatedLog wrapping = simulate_log("office", 4, options, robot);
  robot.wheels.counts_are_cumulative = false;
  const SimulatedLog single = simulate_log("office", 4, options, robot);
  std::array<std::int64_t, 4> total{};
  bool has_wrapped = false;
  for (std::size_t i = 0; i < single.messages.size(); ++i) {
    const auto* since = std::get_if<WheelTicks>(&single.messages[i]);
    if (since == nullptr) continue;
    const auto& sum = std::get<WheelTicks>(wrapping.messages[i]);
    for (std::size_t wheel = 0; wheel < 4; ++wheel) {
      total[wheel] += since->counts[wheel];
      EXPECT_LT(std::abs(sum.counts[wheel]), 2049);
      EXPECT_EQ((total[wheel] - sum.counts[wheel]) % 4096, 0);
      has_wrapped = has_wrapped || total[wheel] != sum.counts[wheel];
    }
  }
  EXPECT_TRUE(has_wrapped);
}

TEST(Simulate, GyroWithoutNoiseAddsUpToTheTurning) {
  const SimulationOptions options = noise_free(short_run(90.0));
  const SimulatedLog log = simulate_log("office", 5, options);
  const Drive drive = drive_of(log, options);
  double turned = 0.0;
  double vertical = 0.0;
  double samples = 0.0;
  Stamp last{};
  for (const SensorMessage& message : log.messages) {
    if (const auto* imu = std::get_if<ImuSample>(&message)) {
      turned += imu->angular_velocity_rad_s.z() / options.imu.rate_hz;
      vertical += imu->linear_acceleration_m_s2.z();
      samples += 1.0;
      last = imu->stamp;
    }
  }
  EXPECT_NEAR(turned, drive.turned_rad(last.seconds() - options.start_s + 0.005), 1e-6);
  EXPECT_NEAR(vertical / samples, 9.80665, 1e-9);
}

TEST(Simulate, GyroBiasShowsWhileTheRobotStands) {
  SimulationOptions options = short_run(10.0);
  options.drive.standstill_s = 10.0;
  double sum = 0.0;
  double samples = 0.0;
  for (const SensorMessage& message : simulate_log("office", 5, options).messages) {
    if (const auto* imu = std::get_if<ImuSample>(&message)) {
      sum += imu->angular_velocity_rad_s.z();
      samples += 1.0;
    }
  }
  EXPECT_GE(std::abs(sum / samples), 0.0045);
  EXPECT_LE(std::abs(sum / samples), 0.0105);
}

TEST(Simulate, DeadReckoningWithoutNoiseIsTheTruth) {
  SimulationOptions options = noise_free(short_run(60.0));
  options.odometry_poses = true;
  options.laser.beams = 2;
  RobotModel robot;
  robot.wheels.metres_per_count = 1e-6;
  const SimulatedLog log = simulate_log("office", 6, options, robot);
  const Pose2 map_T_odom = log.world.map_T_start;
  Pose2 last;
  Stamp last_stamp{};
  std::size_t compared = 0;
  for (const SensorMessage& message : log.messages) {
    EXPECT_FALSE(std::holds_alternative<WheelTicks>(message) ||
                 std::holds_alternative<ImuSample>(message));
    if (const auto* odometry = std::get_if<OdometryPose>(&message)) {
      last = odometry->odom_T_robot;
      last_stamp = odometry->stamp;
    } else {
      EXPECT_EQ(last_stamp, stamp_of(message)) << "no odometry pose with this scan's stamp";
      const Pose2 expected = *log.truth.nearest(last_stamp, Duration{0});
      const Pose2 off = expected.inverse() * (map_T_odom * last);
      EXPECT_LT(off.translation().norm(), 0.002);
      EXPECT_LT(std::abs(off.yaw), 0.005);
      ++compared;
    }
  }
  EXPECT_GT(compared, 500U);
}

TEST(Simulate, DeadReckoningDriftsAsRealWheelsDo) {
  SimulationOptions options;
  options.odometry_poses = true;
  options.laser.beams = 2;
  const SimulatedLog log = simulate_log("office", 7, options);
  Pose2 last;
  for (const SensorMessage& message : log.messages) {
    if (const auto* odometry = std::get_if<OdometryPose>(&message)) last = odometry->odom_T_robot;
  }
  const Pose2 start_T_end = log.world.map_T_start.inverse() * log.truth.back().pose;
  const double off = (last.translation() - start_T_end.translation()).norm();
  EXPECT_GT(off, 0.2);
  EXPECT_LT(off, 0.05 * log.summary.route_length_m);
}

TEST(Simulate, LaserClockOffsetMovesStampsNotScans) {
  SimulationOptions options = noise_free(short_run(20.0));
  const SimulatedLog exact = simulate_log("office", 8, options);
  options.laser.clock_offset_s = 0.1;
  const SimulatedLog late = simulate_log("office", 8, options);
  const auto a = exact.scans();
  const auto b = late.scans();
  ASSERT_GT(b.size(), 150U);
  for (std::size_t i = 0; i < b.size(); ++i) {
    EXPECT_NEAR((b[i].stamp - a[i].stamp).seconds(), 0.1, 1e-9);
    EXPECT_EQ(a[i].ranges_m[90], b[i].ranges_m[90]);
    EXPECT_EQ(exact.truth.poses()[i].pose, late.truth.poses()[i].pose);
  }
}

TEST(Simulate, SameSeedSameBits) {
  SimulationOptions options = short_run(15.0);
  options.people = 2;
  const auto a = simulate_log("office", 9, options);
  const auto b = simulate_log("office", 9, options);
  const auto scans_a = a.scans();
  const auto scans_b = b.scans();
  ASSERT_EQ(a.messages.size(), b.messages.size());
  ASSERT_EQ(scans_a.size(), scans_b.size());
  for (std::size_t i = 0; i < scans_a.size(); ++i) {
    EXPECT_EQ(scans_a[i].stamp, scans_b[i].stamp);
    for (std::size_t beam = 0; beam < scans_a[i].ranges_m.size(); ++beam) {
      EXPECT_EQ(std::bit_cast<std::uint32_t>(scans_a[i].ranges_m[beam]),
                std::bit_cast<std::uint32_t>(scans_b[i].ranges_m[beam]));
    }
  }
}

TEST(Simulate, PeopleMoveThroughTheScansAndKeepAwayFromTheRobot) {
  SimulationOptions options = noise_free(short_run(60.0));
  options.laser.clock_offset_s = 0.0;
  const auto empty = simulate_log("office", 1, options).scans();
  options.people = 30;
  const SimulatedLog crowded_log = simulate_log("office", 1, options);
  const auto crowded = crowded_log.scans();
  std::size_t hidden = 0;
  for (std::size_t i = 0; i < empty.size(); ++i) {
    for (std::size_t beam = 0; beam < empty[i].ranges_m.size(); ++beam) {
      if (std::isnan(empty[i].ranges_m[beam]) || std::isnan(crowded[i].ranges_m[beam])) continue;
      EXPECT_LE(crowded[i].ranges_m[beam], empty[i].ranges_m[beam]);
      if (crowded[i].ranges_m[beam] < empty[i].ranges_m[beam]) {
        ++hidden;
        EXPECT_GT(crowded[i].ranges_m[beam], 0.1f);
      }
    }
  }
  EXPECT_GT(hidden, 100U);
}

TEST(Simulate, StopsWhenAsked) {
  const World world = make_world("rooms", 1);
  SimulationSink sink;
  sink.progress = [](double done_s, double) { return done_s < 5.0; };
  SimulationOptions options;
  options.laser.beams = 3;
  const SimulationSummary summary = simulate(world, RobotModel{}, options, 1, sink);
  EXPECT_FALSE(summary.complete);
  EXPECT_NEAR(summary.duration_s, 5.0, 0.3);
}

TEST(Simulate, RefusesAScannerThatCannotBe) {
  const World world = make_world("rooms", 1);
  SimulationOptions options;
  options.laser.beams = 1;
  EXPECT_THROW((void)simulate(world, RobotModel{}, options, 1, {}), UsageError);
  options.laser.beams = 100;
  options.laser.sweep_s = 0.2;
  EXPECT_THROW((void)simulate(world, RobotModel{}, options, 1, {}), UsageError);
}

TEST(Drive, PosesBetweenStepsLieOnTheArc) {
  Drive drive({1.0, 2.0, 0.5});
  for (int i = 0; i < 100; ++i) drive.append(0.5, 0.25);
  const Pose2 expected = Pose2{1.0, 2.0, 0.5} * exp(Tangent2(0.5 * 1.2345, 0.0, 0.25 * 1.2345));
  const Pose2 pose = drive.pose_at(1.2345);
  EXPECT_NEAR(pose.x, expected.x, 1e-12);
  EXPECT_NEAR(pose.y, expected.y, 1e-12);
  EXPECT_NEAR(pose.yaw, expected.yaw, 1e-12);
  EXPECT_NEAR(drive.travelled_m(1.2345), 0.5 * 1.2345, 1e-12);
  EXPECT_NEAR(drive.turned_rad(1.2345), 0.25 * 1.2345, 1e-12);
  EXPECT_EQ(drive.pose_at(-1.0), (Pose2{1.0, 2.0, 0.5}));
  EXPECT_EQ(drive.pose_at(100.0), drive.last_pose());
}

TEST(Drive, KeepsItsLimits) {
  const DriveOptions options;
  const Drive drive = drive_route(make_world("office", 3), 0.25, options);
  for (double time = 0.0; time + 0.02 < drive.duration_s(); time += 0.02) {
    EXPECT_LE(drive.travelled_m(time + 0.02) - drive.travelled_m(time),
              0.02 * options.speed_m_s + 1e-9);
    EXPECT_LE(std::abs(drive.turned_rad(time + 0.02) - drive.turned_rad(time)),
              0.02 * options.yaw_rate_rad_s + 1e-9);
  }
  EXPECT_EQ(drive.travelled_m(options.standstill_s), 0.0);
}

TEST(Drive, LapsGoTheSameWay) {
  const World world = make_world("office", 3);
  const Drive one = drive_route(world, 0.25);
  const Drive three = drive_route(world, 0.25, {.laps = 3});
  // The first ends where the route does, a lap where it began.
  EXPECT_GT(three.duration_s(), 2.8 * one.duration_s());
  EXPECT_LT((three.last_pose().translation() - world.map_T_start.translation()).norm(), 0.5);
  for (double time = 0.0; time < three.duration_s(); time += 0.5) {
    const Eigen::Vector2d at = three.pose_at(time).translation();
    double nearest = 10.0;
    for (double t = 0.0; t < 0.34 * three.duration_s(); t += 0.1)
      nearest = std::min(nearest, (three.pose_at(t).translation() - at).norm());
    EXPECT_LT(nearest, 0.3) << time;
  }
}

}  // namespace
}  // namespace loopstone
