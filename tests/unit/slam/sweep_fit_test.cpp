#include "slam/sweep_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "support/segment_world.hpp"

namespace loopstone::test {
namespace {

/// Scans of a room by a robot that sways: each with its velocity and its pose at mid-sweep, as the
/// front end finds it.
struct Drive {
  std::deque<LaserScan> scans{};
  std::vector<MovingScan> moving{};
};

struct Kind {
  double sweep_s = 0.075;
  double turns_rad_s = 0.7;  ///< at most, to the left and to the right in turn
  double told_s = 0.0;       ///< what the scan says of its sweep
  std::size_t beams = 361;
  double fov_rad = 1.5 * kPi;
};

Drive drive_of(const Kind& kind, std::uint64_t seed) {
  constexpr double kStepS = 0.2;
  Rng rng(seed);
  Scanner scanner{.angle_min_rad = -0.5 * kind.fov_rad,
                  .angle_increment_rad = kind.fov_rad / static_cast<double>(kind.beams),
                  .beams = kind.beams,
                  .noise_m = 0.01};
  const Pose2 robot_T_lidar{0.14, 0.0, 0.0};
  Drive drive;
  Pose2 pose{3.0, 2.5, 0.3};
  for (int i = 0; i < 240; ++i) {
    const double phase = 0.15 * i;
    const Tangent2 velocity(0.2 * std::cos(0.05 * i), 0.0, kind.turns_rad_s * std::sin(phase));
    scanner.time_increment_s = kind.sweep_s / static_cast<double>(kind.beams);
    LaserScan scan = scan_from(furnished_room(), pose, robot_T_lidar, scanner, &rng, velocity);
    scan.stamp = Stamp::from_seconds(kStepS * i);
    scan.time_increment_s = kind.told_s / static_cast<double>(kind.beams);
    drive.scans.push_back(std::move(scan));
    const Pose2 at_middle = pose * exp(Tangent2(velocity * (0.5 * kind.sweep_s)));
    const Pose2 noise{rng.normal(0.0, 0.005), rng.normal(0.0, 0.005), rng.normal(0.0, 0.002)};
    drive.moving.push_back({&drive.scans.back(), robot_T_lidar, at_middle * noise, velocity});
    pose = pose * exp(Tangent2(velocity * kStepS));
  }
  return drive;
}

TEST(SweepFit, FindsTheSweepAndItsDirection) {
  for (const double sweep_s : {0.075, 0.02, -0.05}) {
    const Drive drive = drive_of({.sweep_s = sweep_s}, 1);
    const auto fit = fit_sweep(drive.moving);
    ASSERT_TRUE(fit);
    EXPECT_TRUE(fit->is_off());
    EXPECT_NEAR(fit->sweep_s, sweep_s, 0.002);
    EXPECT_LT(std::abs(fit->sweep_s - sweep_s), 4.0 * fit->sigma_s + 0.0003) << fit->sigma_s;
  }
}

TEST(SweepFit, OfAWholeTurnToo) {
  const Drive drive = drive_of({.sweep_s = 0.16, .beams = 360, .fov_rad = 2.0 * kPi}, 2);
  const auto fit = fit_sweep(drive.moving);
  ASSERT_TRUE(fit);
  EXPECT_TRUE(fit->is_off());
  EXPECT_NEAR(fit->sweep_s, 0.16, 0.003);
}

TEST(SweepFit, ScansOfOneMomentHaveNone) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Drive drive = drive_of({.sweep_s = 0.0}, seed);
    const auto fit = fit_sweep(drive.moving);
    ASSERT_TRUE(fit);
    EXPECT_FALSE(fit->is_off());
    EXPECT_LT(std::abs(fit->sweep_s), 4.0 * fit->sigma_s);
    EXPECT_LT(fit->sigma_s, 0.002);
  }
}

TEST(SweepFit, ARobotThatNeverTurnsTellsNothing) {
  EXPECT_FALSE(fit_sweep(drive_of({.turns_rad_s = 0.02}, 1).moving));
  EXPECT_FALSE(fit_sweep({}));
}

TEST(SweepFit, ScansThatTellTheirSweepAreNotAsked) {
  const Drive drive = drive_of({.told_s = 0.075}, 1);
  std::vector<SubmapRecord> submaps(1);
  std::deque<TrackedPose> track;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    MappedScan mapped{.scan = drive.scans[i], .index = i};
    if (i % 2 == 0) mapped.scan.time_increment_s = 0.0;
    submaps[0].scans.add(std::make_shared<const MappedScan>(std::move(mapped)));
    track.push_back({drive.scans[i].stamp, Pose2{0.1 * static_cast<double>(i), 0.0, 0.0}, {}});
  }
  const auto untold = untold_scans(submaps, track, 0);
  ASSERT_EQ(untold.size(), drive.scans.size() / 2);
  EXPECT_NEAR(untold[5].velocity.x(), 0.5, 1e-9) << "10 cm in 0.2 s";
  EXPECT_TRUE(untold_scans(submaps, track, 1).empty());
}

TEST(SweepFit, ScansBesideAJumpOfThePathAreNotAsked) {
  const Drive drive = drive_of({}, 1);
  std::vector<SubmapRecord> submaps(1);
  std::deque<TrackedPose> track;
  constexpr std::size_t kJump = 100;  // of the path, where a gap was bridged
  const Pose2 elsewhere{0.3, 0.1, 1.5};
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    MappedScan mapped{.scan = drive.scans[i], .index = i};
    mapped.robot_T_lidar = drive.moving[i].robot_T_lidar;
    const Pose2& pose = drive.moving[i].local_T_robot;
    mapped.local_T_robot = i < kJump ? pose : pose * elsewhere;
    track.push_back({drive.scans[i].stamp, mapped.local_T_robot, {}});
    submaps[0].scans.add(std::make_shared<const MappedScan>(std::move(mapped)));
  }
  const auto untold = untold_scans(submaps, track, 0);
  for (const MovingScan& scan : untold) EXPECT_LT(std::abs(scan.velocity.z()), 1.0);
  EXPECT_GT(untold.size(), drive.scans.size() - 12) << "the others are";
  const auto fit = fit_sweep(untold);
  ASSERT_TRUE(fit);
  EXPECT_TRUE(fit->is_off());
  EXPECT_NEAR(fit->sweep_s, 0.075, 0.003);
}

}  // namespace
}  // namespace loopstone::test
