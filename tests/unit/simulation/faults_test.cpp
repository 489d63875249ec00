#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "loopstone/geometry/angle.hpp"
#include "support/simulated_log.hpp"

namespace loopstone {
namespace {

using test::noise_free;
using test::simulate_log;
using test::SimulatedLog;
using Fault = SimulatedOdometryFault;

SimulatedLog log_with(const SimulatedFaults& faults, bool poses = true) {
  SimulationOptions options = noise_free({.duration_s = 60.0, .odometry_poses = poses});
  options.laser.beams = 91;
  options.laser.rate_hz = 2.0;
  options.faults = faults;
  return simulate_log("office", 3, options);
}

Trajectory odometry_of(const SimulatedLog& log) {
  Trajectory odometry;
  for (const SensorMessage& message : log.messages) {
    const auto* pose = std::get_if<OdometryPose>(&message);
    if (pose == nullptr) continue;
    if (!odometry.empty() && odometry.back().stamp >= pose->stamp) continue;
    odometry.append(pose->stamp, pose->odom_T_robot);
  }
  return odometry;
}

struct Way {
  double travelled_m = 0.0;
  double turned_rad = 0.0;  ///< to the left
  double largest_step_m = 0.0;
};

Way way_of(const Trajectory& trajectory) {
  Way way;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    const Pose2 step = trajectory.poses()[i - 1].pose.inverse() * trajectory.poses()[i].pose;
    way.travelled_m += step.x;
    way.turned_rad += step.yaw;
    way.largest_step_m = std::max(way.largest_step_m, std::abs(step.x));
  }
  return way;
}

TEST(SimulatedFaults, StuckWheelsStandFromTheMomentOnThatIsGiven) {
  const Trajectory odometry = odometry_of(log_with({.odometry = Fault::kStuck, .from_s = 30.0}));
  const Trajectory healthy = odometry_of(log_with({}));
  const Pose2 stuck_at =
      odometry.at_clamped(odometry.front().stamp + Duration{31'000'000'000}).value();
  EXPECT_EQ(odometry.back().pose, stuck_at);
  EXPECT_GT(std::hypot(healthy.back().pose.x - stuck_at.x, healthy.back().pose.y - stuck_at.y),
            1.0);
}

TEST(SimulatedFaults, AFaultMayEnd) {
  const Way broken =
      way_of(odometry_of(log_with({.odometry = Fault::kStuck, .from_s = 20.0, .to_s = 30.0})));
  const Way healthy = way_of(odometry_of(log_with({})));
  EXPECT_LT(broken.travelled_m, healthy.travelled_m - 2.0);
  EXPECT_GT(broken.travelled_m, 0.4 * healthy.travelled_m);
}

TEST(SimulatedFaults, ScaledAndMirroredWheels) {
  const Way healthy = way_of(odometry_of(log_with({})));
  const Way scaled = way_of(odometry_of(log_with({.odometry = Fault::kScaled, .strength = 1.5})));
  EXPECT_NEAR(scaled.travelled_m, 1.5 * healthy.travelled_m, 0.05);
  EXPECT_NEAR(scaled.turned_rad, 1.5 * healthy.turned_rad, 0.05);
  const Way mirrored = way_of(odometry_of(log_with({.odometry = Fault::kMirrored})));
  EXPECT_NEAR(mirrored.travelled_m, healthy.travelled_m, 0.05);
  EXPECT_NEAR(mirrored.turned_rad, -healthy.turned_rad, 0.05);
}

TEST(SimulatedFaults, MirroredTurnsTheGyroTooAndNothingElse) {
  const SimulatedLog healthy = log_with({}, false);
  const SimulatedLog mirrored = log_with({.odometry = Fault::kMirrored}, false);
  ASSERT_EQ(healthy.messages.size(), mirrored.messages.size());
  for (std::size_t i = 0; i < healthy.messages.size(); ++i) {
    if (const auto* imu = std::get_if<ImuSample>(&healthy.messages[i])) {
      const auto& other = std::get<ImuSample>(mirrored.messages[i]);
      ASSERT_NEAR(other.angular_velocity_rad_s.z(), -imu->angular_velocity_rad_s.z(), 1e-12);
    }
    if (const auto* scan = std::get_if<LaserScan>(&healthy.messages[i])) {
      ASSERT_EQ(scan->ranges_m, std::get<LaserScan>(mirrored.messages[i]).ranges_m);
    }
  }
}

TEST(SimulatedFaults, WheelsThatLagAreLateByThatMuch) {
  const Trajectory healthy = odometry_of(log_with({}));
  const Trajectory late = odometry_of(log_with({.odometry = Fault::kLagging, .strength = 0.5}));
  for (double seconds = 10.0; seconds < 55.0; seconds += 1.7) {
    const Stamp stamp = healthy.front().stamp + Duration::from_seconds(seconds);
    const Pose2 then = healthy.at_clamped(stamp - Duration{500'000'000}).value();
    const Pose2 said = late.at_clamped(stamp).value();
    EXPECT_NEAR(std::hypot(said.x - then.x, said.y - then.y), 0.0, 0.03) << seconds;
  }
}

TEST(SimulatedFaults, JumpsComeNowAndThen) {
  const Trajectory odometry = odometry_of(log_with({.odometry = Fault::kJumping, .strength = 2.0}));
  int jumps = 0;
  for (std::size_t i = 1; i < odometry.size(); ++i) {
    const Pose2 step = odometry.poses()[i - 1].pose.inverse() * odometry.poses()[i].pose;
    if (std::hypot(step.x, step.y) > 0.1 || std::abs(step.yaw) > 0.1) ++jumps;
  }
  EXPECT_GE(jumps, 3);
  EXPECT_LE(jumps, 20);
}

TEST(SimulatedFaults, MissingWheelsLeaveTheGyro) {
  const SimulatedLog log = log_with({.odometry = Fault::kMissing}, false);
  int samples = 0;
  for (const SensorMessage& message : log.messages) {
    EXPECT_FALSE(std::holds_alternative<WheelTicks>(message));
    if (std::holds_alternative<ImuSample>(message)) ++samples;
  }
  EXPECT_GT(samples, 5000);
  EXPECT_TRUE(odometry_of(log_with({.odometry = Fault::kMissing})).empty());
}

TEST(SimulatedFaults, LostScansAreNeitherInTheLogNorInTheTruth) {
  const SimulatedLog whole = log_with({});
  const SimulatedLog log = log_with({.scans_dropped = 0.3});
  const double share =
      static_cast<double>(log.scans().size()) / static_cast<double>(whole.scans().size());
  EXPECT_NEAR(share, 0.7, 0.15);
  EXPECT_EQ(log.truth.size(), log.scans().size());
  EXPECT_EQ(log.summary.scans, static_cast<std::int64_t>(log.scans().size()));
}

TEST(SimulatedFaults, GlassStaysWhereItIsAndReturnsNothing) {
  const auto whole = log_with({}).scans();
  const auto glassy = log_with({.glass = 0.2}).scans();
  ASSERT_EQ(whole.size(), glassy.size());
  std::size_t beams = 0;
  std::size_t lost = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (std::size_t beam = 0; beam < whole[i].ranges_m.size(); ++beam) {
      if (!std::isfinite(whole[i].ranges_m[beam])) continue;
      ++beams;
      if (std::isinf(glassy[i].ranges_m[beam])) {
        ++lost;
      } else {
        ASSERT_EQ(whole[i].ranges_m[beam], glassy[i].ranges_m[beam]);
      }
    }
  }
  EXPECT_NEAR(static_cast<double>(lost) / static_cast<double>(beams), 0.2, 0.08);
  // The robot stands for the first moments: it sees the same panes in every scan.
  for (std::size_t beam = 0; beam < glassy[0].ranges_m.size(); ++beam) {
    EXPECT_EQ(std::isinf(glassy[0].ranges_m[beam]), std::isinf(glassy[1].ranges_m[beam]));
  }
}

}  // namespace
}  // namespace loopstone
