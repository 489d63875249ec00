#include "loopstone/odometry/odometer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <variant>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/odometry/dead_reckoning.hpp"

namespace loopstone {
namespace {

Stamp at(double seconds) {
  return {static_cast<std::int64_t>(1'300'000'000'000'000'000) +
          static_cast<std::int64_t>(std::llround(seconds * 1e9))};
}

struct Motion {
  double speed_m_s;
  double rate_rad_s;
};

/// A robot that drives at known speeds, and what its perfect wheels and its biased gyro say. Wheel
/// readings every 25 ms, gyro every 10 ms and 3 ms off, so that the two never meet.
struct Drive {
  double gyro_bias_rad_s = 0.0;
  double duration_s = 10.0;
  bool gyro = true;
  WheelModel wheels{};
  std::function<Motion(double)> motion;

  /// The truth by many small exact arcs.
  [[nodiscard]] Pose2 truth(double seconds) const {
    Pose2 pose;
    const double step = 1e-4;
    const auto steps = static_cast<int>(std::llround(seconds / step));
    for (int i = 0; i < steps; ++i) {
      const Motion now = motion((i + 0.5) * step);
      pose = pose * integrate_arc({now.speed_m_s * step, now.rate_rad_s * step});
    }
    return pose;
  }

  [[nodiscard]] std::vector<SensorMessage> messages() const {
    std::vector<SensorMessage> all;
    double left_m = 0.0;
    double right_m = 0.0;
    std::array<std::int64_t, 4> before{};
    const double step = 1e-3;
    for (int i = 0; i <= static_cast<int>(duration_s / step); ++i) {
      const double now_s = i * step;
      if (i % 25 == 0) {
        const auto right =
            static_cast<std::int64_t>(std::llround(right_m / wheels.metres_per_count));
        const auto left = static_cast<std::int64_t>(std::llround(left_m / wheels.metres_per_count));
        const std::array<std::int64_t, 4> counts{right, left, right, left};
        WheelTicks ticks{at(now_s), counts};
        if (!wheels.counts_are_cumulative) {
          for (std::size_t k = 0; k < 4; ++k) ticks.counts[k] = counts[k] - before[k];
        }
        before = counts;
        all.emplace_back(ticks);
      }
      if (gyro && i % 10 == 3) {
        ImuSample sample{at(now_s)};
        sample.angular_velocity_rad_s.z() = motion(now_s).rate_rad_s + gyro_bias_rad_s;
        all.emplace_back(sample);
      }
      const Motion now = motion(now_s + 0.5 * step);
      left_m += (now.speed_m_s - 0.5 * wheels.track_width_m * now.rate_rad_s) * step;
      right_m += (now.speed_m_s + 0.5 * wheels.track_width_m * now.rate_rad_s) * step;
    }
    return all;
  }
};

Drive fine_drive() {
  Drive drive;
  drive.wheels.metres_per_count = 1e-6;  // quantisation is not the subject
  drive.motion = [](double t) { return Motion{0.8 + 0.3 * std::sin(t), 0.7 * std::cos(1.3 * t)}; };
  return drive;
}

Odometer run(const Drive& drive, const OdometryOptions& options = {}) {
  Odometer odometer(drive.wheels, options);
  for (const SensorMessage& message : drive.messages()) {
    if (const auto* ticks = std::get_if<WheelTicks>(&message)) odometer.add(*ticks);
    if (const auto* imu = std::get_if<ImuSample>(&message)) odometer.add(*imu);
  }
  odometer.finish();
  return odometer;
}

double distance(const Pose2& a, const Pose2& b) {
  return (a.translation() - b.translation()).norm();
}

TEST(Odometer, FollowsWheelsAlone) {
  Drive drive = fine_drive();
  drive.gyro = false;
  const auto pose = run(drive).pose_at(at(10.0));
  ASSERT_TRUE(pose);
  EXPECT_LT(distance(pose->pose, drive.truth(10.0)), 2e-3);
  EXPECT_LT(std::abs(wrap_angle(pose->pose.yaw - drive.truth(10.0).yaw)), 1e-4);
}

TEST(Odometer, FollowsTheGyroWhereWheelsSlip) {
  Drive drive = fine_drive();
  Drive wrong = drive;
  wrong.wheels.track_width_m *= 2.0;  // a skid-steered robot turns less than its wheels say
  Odometer odometer(drive.wheels);
  for (const SensorMessage& message : wrong.messages()) {
    if (const auto* ticks = std::get_if<WheelTicks>(&message)) odometer.add(*ticks);
    if (const auto* imu = std::get_if<ImuSample>(&message)) odometer.add(*imu);
  }
  odometer.finish();
  const auto pose = odometer.pose_at(at(10.0));
  ASSERT_TRUE(pose);
  EXPECT_LT(std::abs(wrap_angle(pose->pose.yaw - drive.truth(10.0).yaw)), 2e-3);
  EXPECT_LT(distance(pose->pose, drive.truth(10.0)), 1e-2);
  EXPECT_GT(odometer.turned_by_gyro(), 390);
}

TEST(Odometer, InterpolatesBetweenReadings) {
  const Drive drive = fine_drive();
  const Odometer odometer = run(drive);
  for (const double t : {3.0, 3.0071, 3.0124, 3.02499, 7.77}) {
    const auto pose = odometer.pose_at(at(t));
    ASSERT_TRUE(pose);
    EXPECT_LT(distance(pose->pose, drive.truth(t)), 5e-3) << t;
  }
}

TEST(Odometer, NearestAndEulerAreWorseButClose) {
  const Drive drive = fine_drive();
  OdometryOptions rough;
  rough.alignment = StampAlignment::kNearest;
  rough.integration = StepShape::kEuler;
  const Pose2 truth = drive.truth(10.0);
  const double fine_error = distance(run(drive).pose_at(at(10.0))->pose, truth);
  const double rough_error = distance(run(drive, rough).pose_at(at(10.0))->pose, truth);
  EXPECT_LT(fine_error, rough_error);
  EXPECT_LT(rough_error, 0.1);
}

TEST(Odometer, LearnsTheGyroBiasWhileStanding) {
  Drive drive = fine_drive();
  drive.gyro_bias_rad_s = 0.02;
  drive.motion = [](double t) { return t < 5.0 ? Motion{0.0, 0.0} : Motion{0.5, 0.3}; };
  const Odometer odometer = run(drive);
  EXPECT_NEAR(odometer.gyro_bias_rad_s(), 0.02, 5e-4);
  EXPECT_NEAR(odometer.pose_at(at(10.0))->pose.yaw, 1.5, 0.02)
      << "0.02 rad/s over ten seconds would be 0.2 rad";

  OdometryOptions naive;
  naive.use_standstill = false;
  EXPECT_NEAR(run(drive, naive).pose_at(at(10.0))->pose.yaw, 1.7, 0.01);
}

TEST(Odometer, RobotTurnedByHandStillTurns) {
  Drive drive = fine_drive();
  drive.motion = [](double t) { return Motion{0.0, t < 4.0 ? 0.0 : 0.5}; };
  Odometer odometer(drive.wheels);
  for (const SensorMessage& message : drive.messages()) {
    if (const auto* ticks = std::get_if<WheelTicks>(&message)) {
      odometer.add(WheelTicks{ticks->stamp, {}});  // the wheels are off the ground
    }
    if (const auto* imu = std::get_if<ImuSample>(&message)) odometer.add(*imu);
  }
  odometer.finish();
  EXPECT_NEAR(odometer.pose_at(at(8.0))->pose.yaw, 2.0, 0.02);
  EXPECT_NEAR(odometer.gyro_bias_rad_s(), 0.0, 1e-3);
  EXPECT_NEAR(odometer.turned_by_hand_rad(), 3.0, 0.05);  // by the end of ten seconds
}

TEST(Odometer, ARobotThatTurnsItselfIsNotTurnedByHand) {
  Drive drive = fine_drive();
  // Slowly on the spot, too: some readings count nothing.
  drive.motion = [](double t) { return Motion{t < 4.0 ? 0.3 : 0.0, t < 7.0 ? 0.5 : 0.06}; };
  EXPECT_NEAR(run(drive).turned_by_hand_rad(), 0.0, 0.01);
}

TEST(Odometer, FallsBackToWheelsWhenTheGyroDies) {
  const Drive drive = fine_drive();
  Odometer odometer(drive.wheels);
  for (const SensorMessage& message : drive.messages()) {
    if (const auto* ticks = std::get_if<WheelTicks>(&message)) odometer.add(*ticks);
    const auto* imu = std::get_if<ImuSample>(&message);
    if (imu != nullptr && imu->stamp < at(5.0)) odometer.add(*imu);
  }
  odometer.finish();
  EXPECT_LT(distance(odometer.pose_at(at(10.0))->pose, drive.truth(10.0)), 1e-2);
  EXPECT_GT(odometer.turned_by_wheels(), 150);
}

TEST(Odometer, CumulativeCountsThatWrapGiveTheSamePath) {
  Drive drive = fine_drive();
  drive.gyro = false;
  drive.wheels.metres_per_count = 1e-4;
  const Pose2 plain = run(drive).pose_at(at(10.0))->pose;
  drive.wheels.counts_are_cumulative = true;
  drive.wheels.counter_bits = 12;
  std::vector<SensorMessage> messages = drive.messages();
  Odometer odometer(drive.wheels);
  for (const SensorMessage& message : messages) {
    WheelTicks ticks = std::get<WheelTicks>(message);
    for (auto& count : ticks.counts) count = ((count + 4000) % 4096 + 4096) % 4096;
    odometer.add(ticks);
  }
  odometer.finish();
  EXPECT_LT(distance(odometer.pose_at(at(10.0))->pose, plain), 1e-9);
}

TEST(Odometer, ACounterThatStartsAgainIsNoDrive) {
  WheelModel wheels;
  wheels.counts_are_cumulative = true;
  Odometer odometer(wheels);
  odometer.add(WheelTicks{at(0.0), {5000000, 5000000, 5000000, 5000000}});
  odometer.add(WheelTicks{at(0.025), {5000010, 5000010, 5000010, 5000010}});
  odometer.add(WheelTicks{at(0.05), {0, 0, 0, 0}});
  odometer.add(WheelTicks{at(0.075), {10, 10, 10, 10}});
  odometer.finish();
  EXPECT_NEAR(odometer.pose_at(at(0.075))->pose.x, 20 * wheels.metres_per_count, 1e-12);
}

TEST(Odometer, TellsForHowLongNobodyCountedTheWheels) {
  const auto run_with_gap = [](bool cumulative) {
    WheelModel wheels;
    wheels.counts_are_cumulative = cumulative;
    Odometer odometer(wheels);
    for (int i = 0; i <= 200; ++i) {
      if (i > 60 && i < 120) continue;  // from 1.2 to 2.4 s
      const std::int64_t count = cumulative ? 5 * i : 5;
      odometer.add(WheelTicks{at(0.02 * i), {count, count, count, count}});
    }
    odometer.finish();
    return odometer;
  };
  const Odometer lost = run_with_gap(false);
  EXPECT_EQ(lost.untold_s(at(0.2), at(1.0)), 0.0);
  EXPECT_NEAR(lost.untold_s(at(0.2), at(3.0)), 1.2, 1e-9);
  EXPECT_NEAR(lost.untold_s(at(2.0), at(3.0)), 0.4, 1e-9);
  EXPECT_EQ(run_with_gap(true).untold_s(at(0.2), at(3.0)), 0.0) << "the counter went on";

  Odometer told(WheelModel{});
  told.add(OdometryPose{at(0.0), {}});
  told.add(OdometryPose{at(5.0), {3.0, 0.0, 0.0}});
  EXPECT_EQ(told.untold_s(at(0.0), at(5.0)), 0.0) << "the pose says all";
}

TEST(Odometer, PassesTheLogsOwnOdometryThrough) {
  Odometer odometer(WheelModel{});
  const Pose2 first{3.0, -2.0, 1.0};
  const Pose2 second{3.1, -1.9, 1.2};
  odometer.add(OdometryPose{at(1.0), first});
  odometer.add(OdometryPose{at(2.0), second});
  odometer.add(OdometryPose{at(1.5), Pose2{9.0, 9.0, 0.0}});    // late: ignored
  odometer.add(WheelTicks{at(1.7), {1000, 1000, 1000, 1000}});  // of the other kind: ignored
  EXPECT_EQ(odometer.pose_at(at(1.0))->pose, first);
  EXPECT_EQ(odometer.pose_at(at(2.0))->pose, second);
  EXPECT_LT(distance(odometer.pose_at(at(1.5))->pose, interpolate(first, second, 0.5)), 1e-12);
  EXPECT_EQ(*odometer.newest(), at(2.0));
}

TEST(Odometer, TheLogsOwnOdometryHasTheGyroAsAWitness) {
  for (const double sign : {1.0, -1.0}) {
    Odometer odometer(WheelModel{});
    Odometer silent(WheelModel{});
    double yaw_rad = 0.0;
    for (int i = 0; i < 500; ++i) {
      const double rate_rad_s = 0.8 * std::sin(0.02 * i);
      yaw_rad += 0.02 * rate_rad_s;
      ImuSample sample{.stamp = at(0.02 * i)};
      sample.angular_velocity_rad_s.z() = sign * rate_rad_s + 0.02;
      odometer.add(sample);
      if (i % 5 != 0) continue;
      odometer.add(OdometryPose{at(0.02 * i), Pose2{0.0, 0.0, yaw_rad}});
      silent.add(OdometryPose{at(0.02 * i), Pose2{0.0, 0.0, yaw_rad}});
    }
    ASSERT_TRUE(odometer.wheels_with_gyro());
    EXPECT_NEAR(*odometer.wheels_with_gyro(), sign, 0.05);
    EXPECT_EQ(odometer.pose_at(at(5.0))->pose, silent.pose_at(at(5.0))->pose) << "a witness only";
    EXPECT_FALSE(silent.wheels_with_gyro());
  }
}

TEST(Odometer, ExtrapolatesALittleAndThenRefuses) {
  const Drive drive = fine_drive();
  const Odometer odometer = run(drive);
  const auto near = odometer.pose_at(at(10.05));
  ASSERT_TRUE(near);
  EXPECT_LT(distance(near->pose, drive.truth(10.05)), 0.01);
  EXPECT_GT(near->covariance.trace(), odometer.pose_at(at(10.0))->covariance.trace());
  EXPECT_FALSE(odometer.pose_at(at(10.3)));
}

TEST(Odometer, BeforeTheFirstReadingAndWithoutAny) {
  Odometer odometer(WheelModel{});
  EXPECT_FALSE(odometer.pose_at(at(0.0)));
  EXPECT_FALSE(odometer.newest());
  EXPECT_FALSE(odometer.motion_between(at(0.0), at(1.0)));
  odometer.add(WheelTicks{at(1.0), {7, 7, 7, 7}});
  EXPECT_EQ(odometer.pose_at(at(0.9))->pose, Pose2{});
  EXPECT_EQ(odometer.pose_at(at(1.0))->pose, Pose2{}) << "the first counts have no known duration";
  EXPECT_FALSE(odometer.pose_at(at(0.5)));
}

TEST(Odometer, ForgetsWhatIsLongPast) {
  Drive drive = fine_drive();
  drive.duration_s = 30.0;
  const Odometer odometer = run(drive);
  EXPECT_FALSE(odometer.pose_at(at(5.0)));
  EXPECT_TRUE(odometer.pose_at(at(25.0)));
}

TEST(Odometer, UncertaintyGrowsAlongThePath) {
  const Odometer odometer = run(fine_drive());
  double before = 0.0;
  for (double t = 1.0; t < 10.0; t += 1.0) {
    const double now = odometer.pose_at(at(t))->covariance.trace();
    EXPECT_GT(now, before);
    before = now;
  }
}

TEST(Odometer, MotionBetweenIsThePosesDifferenceWithItsOwnCovariance) {
  const Odometer odometer = run(fine_drive());
  const auto motion = odometer.motion_between(at(4.013), at(5.501));
  const Pose2 expected =
      odometer.pose_at(at(4.013))->pose.inverse() * odometer.pose_at(at(5.501))->pose;
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->pose, expected);
  EXPECT_LT(motion->covariance.trace(), odometer.pose_at(at(5.501))->covariance.trace());
  // Compounding the covariance of the first part with that of the motion gives that of the whole.
  const PoseWithCovariance2 whole = compound(*odometer.pose_at(at(4.013)), *motion);
  EXPECT_LT((whole.covariance - odometer.pose_at(at(5.501))->covariance).norm(),
            1e-6 * whole.covariance.norm() + 1e-12);
}

TEST(Odometer, RestartMovesThePathAndForgetsTheUncertainty) {
  const Drive drive = fine_drive();
  Odometer plain = run(drive);
  Odometer restarted = run(drive);
  const Pose2 start{10.0, 20.0, 0.5};
  restarted.restart_at(start, at(9.0));
  EXPECT_EQ(restarted.pose_at(at(9.0))->pose, start);
  EXPECT_EQ(restarted.pose_at(at(9.0))->covariance.norm(), 0.0);
  const Pose2 moved = plain.pose_at(at(9.0))->pose.inverse() * plain.pose_at(at(9.8))->pose;
  EXPECT_LT(distance(restarted.pose_at(at(9.8))->pose, start * moved), 1e-9);
}

TEST(Odometer, RestartMovesTheLogsOwnOdometryToo) {
  Odometer odometer(WheelModel{});
  odometer.add(OdometryPose{at(1.0), {1.0, 0.0, 0.0}});
  odometer.restart_at({5.0, 5.0, kPi / 2.0}, at(1.0));
  odometer.add(OdometryPose{at(2.0), {2.0, 0.0, 0.0}});
  const Pose2 pose = odometer.pose_at(at(2.0))->pose;
  EXPECT_NEAR(pose.x, 5.0, 1e-12);
  EXPECT_NEAR(pose.y, 6.0, 1e-12);
}

TEST(Odometer, BadReadingsAreIgnored) {
  Odometer odometer(WheelModel{});
  odometer.add(WheelTicks{at(1.0), {}});
  odometer.add(WheelTicks{at(1.0), {500, 500, 500, 500}});
  odometer.add(WheelTicks{at(0.5), {500, 500, 500, 500}});
  ImuSample nan{at(1.0)};
  nan.angular_velocity_rad_s.z() = std::nan("");
  odometer.add(nan);
  odometer.finish();
  EXPECT_EQ(odometer.pose_at(at(1.0))->pose, Pose2{});
  Odometer poses(WheelModel{});
  poses.add(OdometryPose{at(1.0), {std::nan(""), 0.0, 0.0}});
  EXPECT_FALSE(poses.newest());
}

TEST(GyroBias, ConvergesUnderNoiseAndFollowsAWander) {
  Rng rng(7);
  GyroBias bias;
  for (int i = 0; i < 1000; ++i) bias.learn(at(0.01 * i), rng.normal(0.01, 0.02));
  EXPECT_NEAR(bias.bias_rad_s(), 0.01, 0.003);
  for (int i = 0; i < 1000; ++i) bias.learn(at(600.0 + 0.01 * i), rng.normal(0.013, 0.02));
  EXPECT_NEAR(bias.bias_rad_s(), 0.013, 0.003);
  EXPECT_FALSE(bias.learn(at(700.0), 1.0));
}

TEST(DeadReckoner, GivesAPoseForEveryScan) {
  const Drive drive = fine_drive();
  std::vector<SensorMessage> messages = drive.messages();
  for (int i = 0; i < 100; ++i) {
    LaserScan scan;
    scan.stamp = at(0.1 * i + 0.0137);
    messages.emplace_back(scan);
  }
  std::stable_sort(messages.begin(), messages.end(),
                   [](const auto& a, const auto& b) { return stamp_of(a) < stamp_of(b); });
  DeadReckoner reckoner(drive.wheels);
  for (const SensorMessage& message : messages) reckoner.add(message);
  const DeadReckoningResult result = reckoner.finish();
  EXPECT_EQ(result.scans, 100);
  EXPECT_EQ(result.scans_without_pose, 0);
  ASSERT_EQ(result.trajectory.size(), 100u);
  for (const StampedPose2& pose : result.trajectory.poses()) {
    const double t = (pose.stamp - at(0.0)).seconds();
    EXPECT_LT(distance(pose.pose, drive.truth(t)), 1e-2) << t;
  }
}

TEST(DeadReckoner, GivesAPoseForEveryReadingWithoutScans) {
  const Drive drive = fine_drive();
  DeadReckoner reckoner(drive.wheels);
  for (const SensorMessage& message : drive.messages()) reckoner.add(message);
  const DeadReckoningResult result = reckoner.finish();
  EXPECT_EQ(static_cast<std::int64_t>(result.trajectory.size()), result.wheel_readings);
}

TEST(DeadReckoner, ScansWithoutOdometryAreCounted) {
  DeadReckoner reckoner(WheelModel{});
  for (int i = 0; i < 10; ++i) {
    LaserScan scan;
    scan.stamp = at(0.1 * i);
    reckoner.add(scan);
  }
  const DeadReckoningResult result = reckoner.finish();
  EXPECT_EQ(result.scans_without_pose, 10);
  EXPECT_TRUE(result.trajectory.empty());
}

}  // namespace
}  // namespace loopstone
