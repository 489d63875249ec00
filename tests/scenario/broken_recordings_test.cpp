// Recordings that are broken in the middle: the map may be worse for it, but the run says what
// broke, when, and whose fault it is as far as the data tell; and it is not called good where it
// isn't.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "mapped_drives.hpp"
#include "support/usual_figure.hpp"

namespace loopstone::test {
namespace {

/// 180 beams and the base's own dead reckoning, as old logs have them.
const SimulatedLog& office() {
  static const SimulatedLog log = [] {
    SimulationOptions options{.duration_s = small_scale() ? 120.0 : 200.0, .odometry_poses = true};
    options.laser.beams = 181;
    options.laser.fov_rad = kPi;
    options.laser.rate_hz = 5.0;
    return simulate_log("office", 31, options);
  }();
  return log;
}

double time_in(const SimulatedLog& log, Stamp stamp) {
  return (stamp - log.truth.front().stamp).seconds();
}

/// The log with its scans changed, or left out where nothing is returned.
SimulatedLog with_scans(const std::function<bool(double time_s, LaserScan&)>& change) {
  SimulatedLog log = office();
  std::vector<SensorMessage> kept;
  for (SensorMessage& message : log.messages) {
    auto* scan = std::get_if<LaserScan>(&message);
    if (scan == nullptr || change(time_in(log, scan->stamp), *scan))
      kept.push_back(std::move(message));
  }
  log.messages = std::move(kept);
  return log;
}

std::string warning_of(const MapResult& result, const std::string& words) {
  const auto found = std::find_if(
      result.warnings.begin(), result.warnings.end(),
      [&](const std::string& warning) { return warning.find(words) != std::string::npos; });
  return found == result.warnings.end() ? "" : *found;
}

auto long_gap_of(const MapResult& result) {
  return std::ranges::find_if(
      result.breaks, [](const PathBreak& gap) { return (gap.to - gap.from).seconds() > 3.0; });
}

std::string all_of(const std::vector<std::string>& warnings) {
  std::string text;
  for (const std::string& warning : warnings) text += "\n  " + warning;
  return text;
}

void expect_said(const MapResult& result, const std::string& words) {
  EXPECT_NE(warning_of(result, words), "") << words << all_of(result.warnings);
  EXPECT_NE(result.verdict.overall, Verdict::kGood) << result.verdict.sentence;
}

/// How far the motion between two scans is off the truth [m].
double off_across_m(const Trajectory& estimate, const SimulatedLog& log, double from_s,
                    double to_s) {
  const Stamp start = log.truth.front().stamp;
  const auto pose = [&](const Trajectory& trajectory, double time_s) {
    return trajectory.at_clamped(start + Duration::from_seconds(time_s)).value();
  };
  const Pose2 seen = pose(estimate, from_s).inverse() * pose(estimate, to_s);
  const Pose2 truth = pose(log.truth, from_s).inverse() * pose(log.truth, to_s);
  return std::hypot(seen.x - truth.x, seen.y - truth.y);
}

class GapOf : public testing::TestWithParam<double> {};

TEST_P(GapOf, SecondsIsNoWorseThanOdometry) {
  for (const double start_s : {21.0, 47.0, 63.0}) {
    const double end_s = start_s + GetParam();
    const SimulatedLog log = with_scans(
        [&](double time_s, const LaserScan&) { return time_s < start_s || time_s >= end_s; });
    const MapResult result = map_of(log);
    const double odometry_m = off_across_m(result.odometry, log, start_s - 0.4, end_s + 0.4);
    EXPECT_LE(off_across_m(result.trajectory, log, start_s - 0.4, end_s + 0.4),
              1.5 * odometry_m + 0.05)
        << start_s << all_of(result.warnings);
    if (GetParam() >= 3.0) {
      EXPECT_NE(warning_of(result, "a gap of"), "") << start_s;
    }
    for (const PathBreak& gap : result.breaks)
      EXPECT_NE(gap.bridge, BreakBridge::kNothing) << "odometry was there";
  }
}

INSTANTIATE_TEST_SUITE_P(Scans, GapOf, testing::Values(1.0, 3.0, 5.0, 10.0, 20.0),
                         [](const auto& named) {
                           return std::to_string(static_cast<int>(named.param)) + "s";
                         });

TEST(BrokenRecording, BetweenEqualShelvesARobotThatNothingTellsOfWentOn) {
  for (const std::uint64_t seed : {2U, 3U, 8U}) {
    SimulationOptions options{.duration_s = 60.0};
    options.laser.beams = 541;
    options.realism.loss.on = true;
    const SimulatedLog log = simulate_log("aisles", seed, options);
    const MapResult result = map_of(log);
    EXPECT_FALSE(result.breaks.empty()) << seed;
    EXPECT_LT(ate_rmse_m(result.trajectory, log), 0.05) << seed << all_of(result.warnings);
  }
}

TEST(BrokenRecording, CountsThatAreLostWithTheScansAreNotTakenForStandingStill) {
  SimulationOptions options{.duration_s = small_scale() ? 120.0 : 200.0};
  options.laser.beams = 181;
  options.laser.fov_rad = kPi;
  options.laser.rate_hz = 5.0;
  options.drive.speed_m_s = 0.7;
  SimulatedLog log = simulate_log("office", 31, options);
  std::erase_if(log.messages, [&](const SensorMessage& message) {
    const double time_s = time_in(log, stamp_of(message));
    return (time_s > 30.0 && time_s < 31.5) || (time_s > 70.0 && time_s < 70.7);
  });
  const MapResult result = map_of(log);
  EXPECT_LT(off_across_m(result.trajectory, log, 69.6, 71.2), 0.05) << "shorter than a gap";
  ASSERT_EQ(result.breaks.size(), 1U) << all_of(result.warnings);
  const PathBreak& gap = result.breaks[0];
  EXPECT_NE(gap.bridge, BreakBridge::kOdometry) << "its counts were lost";
  EXPECT_LT(off_across_m(result.trajectory, log, 29.6, 32.0),
            std::max(0.05, 2.0 * (gap.closures > 0 ? gap.tie_sigma_m : gap.bridge_sigma_m())));
  if (gap.bridge == BreakBridge::kNothing && gap.closures == 0) {
    EXPECT_EQ(result.verdict.overall, Verdict::kBad) << result.verdict.sentence;
  }
  EXPECT_EQ(result.statistics.odometry_jumps, 0);
}

/// Scans, counts and gyro are gone for two seconds at a time, while the robot drives and turns, so
/// that it sees in part what nobody saw before.
TEST(BrokenRecording, ARobotIsFoundAheadAfterAllOfItsMessagesWereLost) {
  SimulationOptions options{.duration_s = small_scale() ? 120.0 : 200.0};
  options.laser.beams = 361;
  options.drive.speed_m_s = 0.7;
  int gaps = 0;
  int found = 0;
  for (const char* world : {"office", "rooms", "aisles"}) {
    const SimulatedLog whole = simulate_log(world, 33, options);
    for (const double start_s : {31.0, 43.0, 57.0, 71.0, 83.0, 97.0}) {
      SimulatedLog log = whole;
      std::erase_if(log.messages, [&](const SensorMessage& message) {
        const double time_s = time_in(log, stamp_of(message));
        return (time_s > start_s && time_s < start_s + 2.0) || time_s > start_s + 12.0;
      });
      const MapResult result = map_of(log, {.loop_closure = false});
      ++gaps;
      const bool is_found = std::ranges::all_of(
          result.breaks, [](const PathBreak& gap) { return gap.bridge == BreakBridge::kLaser; });
      const double off_m = off_across_m(result.trajectory, log, start_s - 0.3, start_s + 2.3);
      if (is_found) {
        ++found;
        EXPECT_LT(off_m, 0.05) << world << " " << start_s;
      } else {
        EXPECT_NE(result.verdict.overall, Verdict::kGood) << world << " " << start_s;
      }
    }
  }
  EXPECT_GE(found, gaps - 4) << "of " << gaps;
}

SimulatedLog along_a_corridor() {
  SimulationOptions options{.duration_s = 60.0};
  options.laser.beams = 541;
  options.drive.speed_m_s = 0.7;
  return simulate_log("corridor", 33, options);
}

/// The walls of a corridor say where it is beside them and where it looks.
TEST(BrokenRecording, AlongACorridorAGapThatNothingToldOfLeavesTheWayAloneOpen) {
  SimulatedLog log = along_a_corridor();
  std::erase_if(log.messages, [&](const SensorMessage& message) {
    const double time_s = time_in(log, stamp_of(message));
    return time_s > 30.0 && time_s < 31.8;
  });
  const MapResult result = map_of(log);
  ASSERT_EQ(result.breaks.size(), 1U) << all_of(result.warnings);
  const PathBreak& gap = result.breaks[0];
  ASSERT_EQ(gap.bridge, BreakBridge::kNothing);
  const SymmetricEigen<double, 2> axes =
      symmetric_eigen<double, 2>(gap.covariance.topLeftCorner<2, 2>());
  EXPECT_LT(std::sqrt(axes.values(0)), 0.1);
  EXPECT_GT(std::sqrt(axes.values(1)), 0.3);
  EXPECT_LT(std::sqrt(gap.covariance(2, 2)), 0.02);
  EXPECT_LT(off_across_m(result.trajectory, log, 29.6, 32.2), 2.0 * gap.bridge_sigma_m());
  // The path after it is no better known.
  const auto sigma_m = [&](double time_s) {
    const Stamp stamp = log.truth.front().stamp + Duration::from_seconds(time_s);
    return largest_sigma(result.covariance_at(stamp).topLeftCorner<2, 2>());
  };
  EXPECT_LT(sigma_m(29.0), 0.5 * gap.bridge_sigma_m());
  EXPECT_GT(sigma_m(33.0), 0.9 * gap.bridge_sigma_m());
}

/// As far along it as odometry tells; how the robot faces its walls tell better.
TEST(BrokenRecording, AlongACorridorAGapLeavesToOdometryTheWayAlone) {
  SimulatedLog log = along_a_corridor();
  std::erase_if(log.messages, [&](const SensorMessage& message) {
    const double time_s = time_in(log, stamp_of(message));
    return std::holds_alternative<LaserScan>(message) && time_s > 30.0 && time_s < 32.5;
  });
  const MapResult result = map_of(log);
  ASSERT_EQ(result.breaks.size(), 1U) << all_of(result.warnings);
  const PathBreak& gap = result.breaks[0];
  ASSERT_EQ(gap.bridge, BreakBridge::kOdometry);
  EXPECT_NEAR(gap.odometry_m, 1.8, 0.3);
  const SymmetricEigen<double, 2> axes =
      symmetric_eigen<double, 2>(gap.covariance.topLeftCorner<2, 2>());
  EXPECT_LT(std::sqrt(axes.values(0)), 0.1);
  EXPECT_LT(std::sqrt(gap.covariance(2, 2)), 0.02);
  const double off_m = off_across_m(result.trajectory, log, 29.6, 32.9);
  EXPECT_LT(off_m, 2.0 * gap.bridge_sigma_m());
  EXPECT_LT(off_m, 0.1);
}

/// It drove on with a blocked laser, and its counts were silent for a part of that.
TEST(BrokenRecording, WhatWasSeenInPartTellsWhereTheRobotIs) {
  SimulationOptions options{.duration_s = 60.0};
  options.laser.beams = 541;
  choose_realism(options.realism, "usual,blocked");
  const SimulatedLog log = simulate_log("rooms", 270, options);
  const MapResult result = map_of(log);
  const auto gap = long_gap_of(result);
  ASSERT_NE(gap, result.breaks.end());
  EXPECT_TRUE(gap->was_found_in_part());
  EXPECT_LT(off_across_m(result.trajectory, log, time_in(log, gap->from), time_in(log, gap->to)),
            2.0 * gap->bridge_sigma_m());
  EXPECT_NE(warning_of(result, "only a part of what it saw then had been seen"), "");
  EXPECT_TRUE(as_usual(ate_rmse_m(result.trajectory, log), 0.08));
}

TEST(BrokenRecording, ARobotThatWasCarriedWhileNoScansCameIsNamed) {
  SimulationOptions options{.duration_s = small_scale() ? 120.0 : 200.0};
  options.laser.beams = 181;
  options.laser.fov_rad = kPi;
  options.laser.rate_hz = 5.0;
  options.realism.carried_blind.on = true;
  options.realism.carried_blind.at_s = 60.0;
  const SimulatedLog log = simulate_log("warehouse", 1, options);
  const MapResult result = map_of(log);
  EXPECT_NE(warning_of(result, "the robot was carried"), "") << all_of(result.warnings);
  const auto carried = std::ranges::find(result.breaks, BreakCause::kCarried, &PathBreak::cause);
  ASSERT_NE(carried, result.breaks.end());
  const bool is_found = carried->bridge == BreakBridge::kLaser || carried->closures > 0;
  if (is_found) {
    EXPECT_NE(warning_of(result, "was carried by about 3.0 m"), "") << all_of(result.warnings);
    EXPECT_LT(off_across_m(result.trajectory, log, time_in(log, carried->from),
                           time_in(log, carried->to)),
              0.1);
  } else {
    EXPECT_EQ(result.verdict.overall, Verdict::kBad) << result.verdict.sentence;
  }
}

/// By dead reckoning alone, which feels no hands: it may face anywhere.
TEST(BrokenRecording, ARobotThatWasCarriedAndTurnedIsFoundWhereItWasPutDown) {
  SimulationOptions options{.duration_s = 90.0, .odometry_poses = true};
  options.laser.beams = 360;
  options.laser.fov_rad = 2.0 * kPi;
  options.laser.range_max_m = 12.0;
  options.realism.carried_blind.on = true;
  options.realism.carried_blind.at_s = 50.0;
  int drives = 0;
  int found = 0;
  for (const char* world : {"wings", "office", "warehouse", "aisles"}) {
    for (const std::uint64_t seed : {21, 22}) {
      if (small_scale() && seed > 21) continue;
      const SimulatedLog log = simulate_log(world, seed, options);
      const MapResult result = map_of(log);
      const auto gap = long_gap_of(result);
      ASSERT_NE(gap, result.breaks.end()) << world << " " << seed;
      const double off_m =
          off_across_m(result.trajectory, log, time_in(log, gap->from), time_in(log, gap->to));
      ++drives;
      if (gap->bridge == BreakBridge::kLaser || gap->closures > 0) {
        ++found;
        EXPECT_LT(off_m, 0.15) << world << " " << seed << all_of(result.warnings);
      } else {
        EXPECT_NE(result.verdict.overall, Verdict::kGood) << world << " " << seed << off_m;
      }
    }
  }
  EXPECT_GE(found, drives * 3 / 4) << "of " << drives;
}

/// By wheels and a gyro, which feels how it is turned, and by dead reckoning, which feels nothing.
/// Along a corridor the laser leaves open how far.
TEST(BrokenRecording, ARobotThatIsCarriedWhileTheLaserLooksOnIsFollowedOrNamed) {
  int drives = 0;
  int followed = 0;
  for (const bool has_gyro : {true, false}) {
    SimulationOptions options{.duration_s = 100.0, .odometry_poses = !has_gyro};
    options.laser.beams = has_gyro ? 541 : 181;
    if (!has_gyro) {
      options.laser.fov_rad = kPi;
      options.laser.rate_hz = 5.0;
    }
    options.realism.carried.on = true;
    options.realism.carried.at_s = 60.0;
    for (const char* world : {"wings", "aisles", "loops"}) {
      for (const std::uint64_t seed : {1, 23}) {
        if (small_scale() && seed > 1) continue;
        const SimulatedLog log = simulate_log(world, seed, options);
        const MapResult result = map_of(log);
        ++drives;
        const std::string drive =
            fmt::format("{} {} {}{}", has_gyro, world, seed, all_of(result.warnings));
        EXPECT_TRUE(result.odometry_episodes.empty()) << "its wheels stood: " << drive;
        const double off_m = off_across_m(result.trajectory, log, 59.0, 67.0);
        if (off_m < 0.15) {
          ++followed;
        } else {
          EXPECT_NE(result.verdict.overall, Verdict::kGood) << off_m << " m: " << drive;
          EXPECT_NE(warning_of(result, "as one that somebody carries"), "") << off_m << drive;
        }
      }
    }
  }
  EXPECT_GE(followed, drives / 2) << "of " << drives;
}

/// Hands that stop bend the sweep otherwise than was expected, so the scan is straightened and
/// aligned anew; it faces the wall of a corridor, and must not slide along it meanwhile.
TEST(BrokenRecording, ARobotThatIsSetDownInACorridorDoesNotSlideAlongIt) {
  SimulationOptions options{.duration_s = 70.0, .odometry_poses = true};
  options.laser.beams = 181;
  options.laser.fov_rad = kPi;
  options.laser.rate_hz = 5.0;
  choose_realism(options.realism, "usual,carried");
  for (const std::uint64_t seed : {20, 27}) {
    const SimulatedLog log = simulate_log("loops", seed, options);
    const MapResult result = map_of(log);
    double leap_m = 0.0;
    const auto& poses = result.trajectory.poses();
    for (std::size_t i = 1; i < poses.size(); ++i) {
      const double time_s = time_in(log, poses[i].stamp);
      if (time_s < 60.0 || time_s > 66.0) continue;
      const double step_m = (poses[i].pose.translation() - poses[i - 1].pose.translation()).norm();
      leap_m = std::max(leap_m, step_m - 0.75 * (poses[i].stamp - poses[i - 1].stamp).seconds());
    }
    EXPECT_LT(leap_m, 0.6) << "beyond what hands go from scan to scan, 0.75 m/s; seed " << seed;
  }
}

/// A small scanner that sees all around.
SimulationOptions seen_around(double range_max_m, double rate_hz,
                              const char* effects = "usual,carried") {
  SimulationOptions options{.odometry_poses = true};
  options.laser.beams = 360;
  options.laser.fov_rad = radians(359.0);
  options.laser.range_max_m = range_max_m;
  options.laser.rate_hz = rate_hz;
  choose_realism(options.realism, effects);
  return options;
}

/// All that tells how far the robot is carried along a corridor goes past it as people do, while
/// its wheels say that it stands.
TEST(BrokenRecording, TheGroundThatPassesACarriedRobotIsNoCrowd) {
  SimulationOptions options = seen_around(12.0, 10.0);
  options.duration_s = 72.0;
  options.laser.noise_m = 0.02;
  const SimulatedLog log = simulate_log("loops", 236, options);
  const MapResult result = map_of(log);
  EXPECT_LT(off_across_m(result.trajectory, log, 56.0, 70.0), 0.15) << all_of(result.warnings);
}

/// Far down a corridor whose doors repeat, some submaps fit some others at several steps; all of
/// them fit at one.
TEST(BrokenRecording, ARobotThatWasCarriedAlongACorridorIsFoundWhereAllOfItFits) {
  SimulationOptions options = seen_around(8.0, 6.0);
  options.duration_s = 110.0;
  const SimulatedLog log = simulate_log("loops", 397, options);
  const MapResult result = map_of(log);
  EXPECT_LT(off_across_m(result.trajectory, log, 58.0, 90.0), 0.5) << all_of(result.warnings);
  EXPECT_GE(std::ranges::count_if(result.loop_closures, &LoopClosure::stands), 4);
}

/// What it saw before and what it sees behind are the two sides of thin walls, mostly.
TEST(BrokenRecording, ARobotThatWasCarriedUnseenIsFoundThoughWallsAreSeenFromTheOtherSide) {
  SimulationOptions options = seen_around(8.0, 6.0, "usual,carried_blind");
  options.duration_s = 150.0;
  options.realism.carried_blind.at_s = 110.0;
  const SimulatedLog log = simulate_log("office", 203, options);
  const MapResult result = map_of(log);
  const auto carried = std::ranges::find(result.breaks, BreakCause::kCarried, &PathBreak::cause);
  ASSERT_NE(carried, result.breaks.end()) << all_of(result.warnings);
  EXPECT_GE(carried->closures, 1);
  EXPECT_LT(off_across_m(result.trajectory, log, 108.0, 116.0), 0.15) << all_of(result.warnings);
}

/// Where rooms are alike a scan that fits is no proof: it is taken for being in another one only if
/// it is.
TEST(BrokenRecording, ARobotThatWasCarriedIntoARoomLikeAnotherIsNotTakenForBeingThere) {
  SimulationOptions options = seen_around(8.0, 6.0, "usual,carried_blind");
  options.duration_s = 150.0;
  options.realism.carried_blind.at_s = 110.0;
  for (const std::uint64_t seed : {403, 405}) {
    if (small_scale() && seed > 403) continue;
    const SimulatedLog log = simulate_log("rooms", seed, options);
    const MapResult result = map_of(log);
    const auto carried = std::ranges::find(result.breaks, BreakCause::kCarried, &PathBreak::cause);
    ASSERT_NE(carried, result.breaks.end()) << all_of(result.warnings);
    if (carried->bridge == BreakBridge::kLaser || carried->closures > 0) {
      EXPECT_LT(off_across_m(result.trajectory, log, 108.0, 116.0), 0.15)
          << seed << all_of(result.warnings);
    } else {
      EXPECT_NE(warning_of(result, "it was not recognised where it was put down"), "");
      EXPECT_EQ(result.verdict.overall, Verdict::kBad) << seed << result.verdict.sentence;
    }
  }
}

/// The robot is lifted at one time and set down where it will be at another; odometry does not
/// notice.
/// \param pause_s  nothing is logged for so long
SimulatedLog carried(SimulatedLog log, double from_s, double to_s, double pause_s) {
  const Stamp start = log.truth.front().stamp;
  const Duration cut = Duration::from_seconds(to_s - from_s - pause_s);
  std::optional<Pose2> before;
  std::optional<Pose2> after;
  std::vector<SensorMessage> kept;
  for (SensorMessage& message : log.messages) {
    const double time_s = time_in(log, stamp_of(message));
    if (time_s >= from_s && time_s < to_s) continue;
    auto* pose = std::get_if<OdometryPose>(&message);
    if (pose != nullptr && time_s < from_s) before = pose->odom_T_robot;
    if (pose != nullptr && time_s >= to_s) {
      if (!after) after = pose->odom_T_robot;
      pose->odom_T_robot = *before * after->inverse() * pose->odom_T_robot;
    }
    if (time_s >= to_s) std::visit([&](auto& m) { m.stamp = m.stamp - cut; }, message);
    kept.push_back(std::move(message));
  }
  log.messages = std::move(kept);
  Trajectory truth;
  for (const auto& [stamp, map_T_robot] : log.truth.poses()) {
    const double time_s = (stamp - start).seconds();
    if (time_s < from_s) truth.append(stamp, map_T_robot);
    if (time_s >= to_s) truth.append(stamp - cut, map_T_robot);
  }
  log.truth = truth;
  return log;
}

TEST(BrokenRecording, ARobotThatMayHaveBeenCarriedAlongACorridorIsNotCalledTied) {
  SimulationOptions options{.duration_s = 60.0, .odometry_poses = true};
  options.laser.beams = 181;
  options.laser.fov_rad = kPi;
  options.laser.rate_hz = 5.0;
  const SimulatedLog log = carried(simulate_log("loops", 2, options), 30.0, 34.3, 4.0);
  const MapResult result = map_of(log);
  const auto gap = long_gap_of(result);
  ASSERT_NE(gap, result.breaks.end());
  EXPECT_EQ(gap->bridge, BreakBridge::kOdometry) << "what the laser saw fits all along";
  const double off_m =
      off_across_m(result.trajectory, log, time_in(log, gap->from), time_in(log, gap->to));
  EXPECT_GT(off_m, 1.0) << "else this shows nothing";
  EXPECT_LT(off_m, 3.0 * gap->bridge_sigma_m());
  EXPECT_NE(warning_of(result, "the robot may have been carried"), "") << all_of(result.warnings);
  EXPECT_NE(result.verdict.overall, Verdict::kGood);
}

TEST(BrokenRecording, AGapThatNothingTiesIsNotCalledGood) {
  // The drive ends before the robot has come back.
  SimulatedLog log =
      with_scans([](double time_s, const LaserScan&) { return time_s < 20.0 || time_s >= 40.0; });
  std::erase_if(log.messages,
                [&](const SensorMessage& m) { return time_in(log, stamp_of(m)) > 60.0; });
  const MapResult result = map_of(log, {.loop_closure = false});
  expect_said(result, "odometry alone carried the path across");
  ASSERT_EQ(result.breaks.size(), 1U);
  EXPECT_EQ(result.breaks[0].closures, 0);
  EXPECT_NEAR(time_in(log, result.breaks[0].to), 40.0, 0.5);
}

TEST(BrokenRecording, WithoutOdometryAGapIsANewPiece) {
  const SimulatedLog log =
      with_scans([](double time_s, const LaserScan&) { return time_s < 20.0 || time_s >= 40.0; });
  MapOptions options{.loop_closure = false};
  options.front_end.odometry = OdometryUse::kIgnore;
  expect_said(map_of(log, options), "nothing tells how the robot moved");
}

TEST(BrokenRecording, ABlockedLaserIsNamedAndOdometryIsNotAccused) {
  Rng rng(3);
  const SimulatedLog log = with_scans([&](double time_s, LaserScan& scan) {
    if (time_s < 30.0 || time_s >= 60.0) return true;
    for (float& range_m : scan.ranges_m) range_m = static_cast<float>(rng.uniform(0.05, 0.29));
    return true;
  });
  const MapResult result = map_of(log);
  expect_said(result, "the laser was blocked from 30");
  EXPECT_TRUE(result.odometry_episodes.empty());
  const double odometry_m = off_across_m(result.odometry, log, 29.0, 61.0);
  EXPECT_LE(off_across_m(result.trajectory, log, 29.0, 61.0), 1.3 * odometry_m + 0.05);
}

/// The laser is covered for 15 s, and for 1.5 s of them all messages are lost: the rest of the way
/// is known, so that it can't have turned round.
TEST(BrokenRecording, OfABlockedLaserAndLostCountsOnlyTheSilenceIsUnknown) {
  SimulationOptions options{.duration_s = small_scale() ? 120.0 : 200.0};
  options.laser.beams = 361;
  int told = 0;
  for (const char* world : {"office", "campus"}) {
    SimulatedLog log = simulate_log(world, 34, options);
    Rng rng(3);
    for (SensorMessage& message : log.messages) {
      auto* scan = std::get_if<LaserScan>(&message);
      const double time_s = time_in(log, stamp_of(message));
      if (scan == nullptr || time_s < 30.0 || time_s >= 45.0) continue;
      for (float& range_m : scan->ranges_m) range_m = static_cast<float>(rng.uniform(0.05, 0.29));
    }
    std::erase_if(log.messages, [&](const SensorMessage& message) {
      const double time_s = time_in(log, stamp_of(message));
      return time_s > 43.0 && time_s < 44.5;
    });
    const MapResult result = map_of(log, {.loop_closure = false});
    // No faster than half a metre a second, of which the likeliest is taken.
    EXPECT_LT(off_across_m(result.trajectory, log, 29.5, 45.5), 1.0)
        << world << all_of(result.warnings);
    EXPECT_NE(result.verdict.overall, Verdict::kGood) << world << result.verdict.sentence;
    told += warning_of(result, "but odometry was silent for a part of it").empty() ? 0 : 1;
  }
  EXPECT_GT(told, 0) << "none of them was found again at once";
}

TEST(BrokenRecording, AFrozenLaserIsNamed) {
  std::vector<float> frozen;
  const SimulatedLog log = with_scans([&](double time_s, LaserScan& scan) {
    if (time_s >= 30.0 && time_s < 60.0) {
      if (frozen.empty()) frozen = scan.ranges_m;
      scan.ranges_m = frozen;
    }
    return true;
  });
  const MapResult result = map_of(log);
  expect_said(result, "the laser was frozen from 30");
  EXPECT_TRUE(result.odometry_episodes.empty());
}

TEST(BrokenRecording, OneScanForEverIsNamed) {
  std::vector<float> first;
  const SimulatedLog log = with_scans([&](double, LaserScan& scan) {
    if (first.empty()) first = scan.ranges_m;
    scan.ranges_m = first;
    return true;
  });
  expect_said(map_of(log), "it repeated one scan to the last bit");
  MapOptions laser_only;
  laser_only.front_end.odometry = OdometryUse::kIgnore;
  expect_said(map_of(log, laser_only), "nothing tells which");
}

TEST(BrokenRecording, TwoBuildingsInOneFileAreTwoPieces) {
  SimulatedLog log = office();
  SimulationOptions options{.duration_s = 60.0, .odometry_poses = true};
  options.laser.beams = 181;
  options.laser.fov_rad = kPi;
  options.laser.rate_hz = 5.0;
  SimulatedLog other = simulate_log("warehouse", 5, options);
  const Duration an_hour = Duration::from_seconds(3600.0);
  const Duration later =
      (stamp_of(log.messages.back()) + an_hour) - stamp_of(other.messages.front());
  for (SensorMessage& message : other.messages) {
    std::visit([&](auto& m) { m.stamp = m.stamp + later; }, message);
    if (auto* pose = std::get_if<OdometryPose>(&message)) {
      pose->odom_T_robot = Pose2{50.0, 37.0, 1.0} * pose->odom_T_robot;
    }
    log.messages.push_back(message);
  }
  const MapResult result = map_of(log);
  expect_said(result, "nothing tells how the robot moved");
  EXPECT_TRUE(result.odometry_episodes.empty());
}

TEST(BrokenRecording, ARobotThatWasCarriedIsNoticed) {
  const SimulatedLog log = carried(office(), 40.0, 56.0, 0.0);
  const MapResult result = map_of(log);
  EXPECT_NE(warning_of(result, "contradict what was seen before"), "") << all_of(result.warnings);
  EXPECT_TRUE(result.odometry_episodes.empty());
}

TEST(BrokenRecording, MirroredBeamsAreNotBlamedOnOdometryAlone) {
  const SimulatedLog log = with_scans([](double, LaserScan& scan) {
    std::reverse(scan.ranges_m.begin(), scan.ranges_m.end());
    return true;
  });
  expect_said(map_of(log), "the laser's beams are listed in the wrong order");
}

TEST(BrokenRecording, RangesThatAreTooLongAreNoticed) {
  const SimulatedLog log = with_scans([](double, LaserScan& scan) {
    for (float& range_m : scan.ranges_m) range_m *= 1.1F;
    return true;
  });
  expect_said(map_of(log), "or the laser's ranges are");
}

TEST(BrokenRecording, ATurnedLaserIsNoticed) {
  const SimulatedLog log = with_scans([](double, LaserScan& scan) {
    scan.angle_min_rad += 5.0 / 57.29578;
    return true;
  });
  // Its beams say that they look farther to the left than they do.
  const std::string corrected = warning_of(map_of(log), "of where its mount says");
  EXPECT_NE(corrected.find("to the right"), std::string::npos) << corrected;
  const std::string said = warning_of(map_of(log, {.calibration = false}), "than its mount says");
  EXPECT_NE(said.find("farther to the right"), std::string::npos) << said;
}

TEST(BrokenRecording, NothingIsSaidOfASoundOne) {
  const MapResult result = map_of(office());
  EXPECT_TRUE(result.breaks.empty()) << all_of(result.warnings);
  EXPECT_TRUE(result.laser_episodes.empty());
  EXPECT_EQ(warning_of(result, "laser"), "") << all_of(result.warnings);
}

}  // namespace
}  // namespace loopstone::test
