#include "loopstone/slam/front_end.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "loopstone/geometry/angle.hpp"
#include "support/pose_near.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

using test::pose_near;
using test::Scanner;

const Pose2 kMount{0.1, 0.0, 0.0};

/// A round through the furnished room and back, 10 cm and about 6 deg a step.
const std::vector<Pose2>& drive() {
  static const auto poses = test::drive_through({{1.0, 1.0},
                                                 {6.0, 1.0},
                                                 {6.0, 2.5},
                                                 {7.0, 3.0},
                                                 {5.5, 5.0},
                                                 {3.5, 5.2},
                                                 {1.0, 3.2},
                                                 {1.0, 1.2},
                                                 {3.0, 1.2}},
                                                0.1, 0.1);
  return poses;
}

Stamp stamp_at(std::size_t i) {
  return {1'000'000'000 + static_cast<std::int64_t>(i) * 100'000'000};
}

LaserScan scan_at(std::size_t i, double noise_m, Rng& rng) {
  auto scan =
      test::scan_from(test::furnished_room(), drive()[i], kMount, {.noise_m = noise_m}, &rng);
  scan.stamp = stamp_at(i);
  return scan;
}

/// Wheels that are 3 % off and turn 2 % too little.
std::vector<Pose2> drifting_odometry() {
  std::vector<Pose2> poses{{3.0, -2.0, 1.0}};  // any start
  for (std::size_t i = 1; i < drive().size(); ++i) {
    const Pose2 step = drive()[i - 1].inverse() * drive()[i];
    poses.push_back(poses.back() * Pose2{1.03 * step.x, 1.03 * step.y, 0.98 * step.yaw + 0.001});
  }
  return poses;
}

struct Outcome {
  std::vector<TrackedScan> scans;
  std::vector<FinishedSubmap> finished;
};

Outcome track(FrontEnd& front_end, bool with_odometry, double noise_m) {
  Outcome outcome;
  Rng rng(21);
  const auto odometry = drifting_odometry();
  for (std::size_t i = 0; i < drive().size(); ++i) {
    std::optional<OdometryReading> odom_T_robot;
    if (with_odometry) odom_T_robot = OdometryReading{odometry[i]};
    outcome.scans.push_back(front_end.add(scan_at(i, noise_m, rng), kMount, odom_T_robot));
    for (auto& submap : outcome.scans.back().finished)
      outcome.finished.push_back(std::move(submap));
  }
  return outcome;
}

void expect_on_track(const Outcome& outcome, double tolerance_m, double tolerance_rad) {
  std::size_t converged = 0;
  for (std::size_t i = 0; i < drive().size(); ++i) {
    const Pose2 truth = drive().front().inverse() * drive()[i];
    ASSERT_TRUE(outcome.scans[i].used);
    ASSERT_TRUE(pose_near(outcome.scans[i].local_T_robot, truth, tolerance_m, tolerance_rad))
        << "scan " << i;
    if (outcome.scans[i].status == MatchStatus::kConverged) ++converged;
  }
  // Now and then the last steps go to and fro between two cells.
  EXPECT_GT(converged, drive().size() * 98 / 100);
}

TEST(FrontEnd, FollowsARobotWithPoorWheels) {
  FrontEnd front_end({}, {}, {});
  const auto outcome = track(front_end, true, 0.01);
  expect_on_track(outcome, 0.03, 0.01);
}

TEST(FrontEnd, FollowsARobotWithoutOdometry) {
  FrontEnd front_end({}, {}, {});
  const auto outcome = track(front_end, false, 0.01);
  expect_on_track(outcome, 0.03, 0.01);
}

TEST(FrontEnd, FirstScanIsTheOriginAndAKeyScan) {
  FrontEnd front_end({}, {}, {});
  Rng rng(1);
  const auto first = front_end.add(scan_at(0, 0.0, rng), kMount, OdometryReading{{7.0, 8.0, 2.0}});
  EXPECT_TRUE(first.used);
  EXPECT_TRUE(first.key);
  EXPECT_EQ(first.local_T_robot, Pose2{});
}

TEST(FrontEnd, KeyScansComeAfterEnoughMotionAndSubmapsAreFilledInTurn) {
  const FrontEndOptions options{
      .key_distance_m = 0.25, .key_angle_rad = 0.25, .submap_length_m = 4.0};
  FrontEnd front_end(options, {}, {});
  auto outcome = track(front_end, true, 0.0);
  Pose2 last_key;
  std::size_t keys = 0;
  for (std::size_t i = 0; i < outcome.scans.size(); ++i) {
    const auto& scan = outcome.scans[i];
    const Pose2 since = last_key.inverse() * scan.local_T_robot;
    const bool far = std::hypot(since.x, since.y) >= 0.25 || std::abs(since.yaw) >= 0.25;
    ASSERT_EQ(scan.key, i == 0 || far) << "scan " << i;
    if (scan.key) {
      last_key = scan.local_T_robot;
      ++keys;
    }
  }
  EXPECT_LT(keys, outcome.scans.size() / 2);
  // The path is about 22 m: every 2 m a submap begins.
  ASSERT_GE(outcome.finished.size(), 7U);
  for (auto& submap : front_end.finish()) outcome.finished.push_back(std::move(submap));
  EXPECT_EQ(outcome.finished.front().first_key, 0U);
  EXPECT_EQ(outcome.finished.back().last_key, keys - 1);
  for (std::size_t i = 0; i + 1 < outcome.finished.size(); ++i) {
    const auto& one = outcome.finished[i];
    const auto& next = outcome.finished[i + 1];
    EXPECT_LT(one.first_key, next.first_key);
    EXPECT_LE(next.first_key, one.last_key) << "consecutive submaps share scans";
    EXPECT_GT(one.submap.surfaces.size(), 50U);
  }
}

TEST(FrontEnd, AScanWithTooFewReturnsKeepsThePrediction) {
  FrontEnd front_end({}, {}, {});
  Rng rng(1);
  const auto odometry = drifting_odometry();
  (void)front_end.add(scan_at(0, 0.0, rng), kMount, OdometryReading{odometry[0]});
  LaserScan blind = scan_at(1, 0.0, rng);
  std::fill(blind.ranges_m.begin(), blind.ranges_m.end(), std::numeric_limits<float>::infinity());
  const auto dropped = front_end.add(blind, kMount, OdometryReading{odometry[1]});
  EXPECT_FALSE(dropped.used);
  EXPECT_FALSE(dropped.key);
  EXPECT_EQ(dropped.status, MatchStatus::kTooFewPairs);
  EXPECT_TRUE(pose_near(dropped.local_T_robot, odometry[0].inverse() * odometry[1], 1e-9, 1e-9));
  EXPECT_GT(dropped.covariance(0, 0), 1e-6);
  const auto back = front_end.add(scan_at(2, 0.0, rng), kMount, OdometryReading{odometry[2]});
  EXPECT_TRUE(pose_near(back.local_T_robot, drive()[0].inverse() * drive()[2], 0.02, 0.01));
}

TEST(FrontEnd, BlindFromTheStartIsNoFailure) {
  FrontEnd front_end({}, {}, {});
  for (int i = 0; i < 5; ++i) {
    const auto tracked =
        front_end.add({.stamp = stamp_at(static_cast<std::size_t>(i))}, kMount, {});
    EXPECT_FALSE(tracked.used);
    EXPECT_EQ(tracked.local_T_robot, Pose2{});
  }
  EXPECT_TRUE(front_end.finish().empty());
}

/// Drives with exact wheels that once claim a jump and a turn that never were. How many scans were
/// searched for.
int searches_when_the_wheels_jump(const FrontEndOptions& options) {
  FrontEnd front_end(options, {}, {});
  Rng rng(1);
  Pose2 odometry;
  int searches = 0;
  for (std::size_t i = 0; i < 60; ++i) {
    if (i > 0) odometry = odometry * (drive()[i - 1].inverse() * drive()[i]);
    if (i == 40) odometry = odometry * Pose2{0.3, 0.2, 0.4};
    const auto tracked = front_end.add(scan_at(i, 0.0, rng), kMount, OdometryReading{odometry});
    if (tracked.searched) ++searches;
    if (i != 40) {
      EXPECT_TRUE(pose_near(tracked.local_T_robot, drive()[0].inverse() * drive()[i], 0.05, 0.02))
          << "scan " << i;
    }
  }
  return searches;
}

TEST(FrontEnd, RecoversWhenTheWheelsJump) {
  EXPECT_LE(searches_when_the_wheels_jump({}), 2) << "searching is for doubtful scans";
}

TEST(FrontEnd, SearchingForEveryScanDoesNoHarm) {
  EXPECT_GT(searches_when_the_wheels_jump({.trusted_score = 1.0}), 5);
}

TEST(FrontEnd, StampsThatGoBackOrRepeatDoNoHarm) {
  FrontEnd front_end({}, {}, {});
  Rng rng(1);
  for (std::size_t i = 0; i < 40; ++i) {
    auto scan = scan_at(i, 0.0, rng);
    if (i % 5 == 1) scan.stamp = stamp_at(i - 1);
    if (i % 7 == 3) scan.stamp = stamp_at(i - 2);
    const auto tracked = front_end.add(scan, kMount, OdometryReading{drive()[i]});
    ASSERT_TRUE(pose_near(tracked.local_T_robot, drive()[0].inverse() * drive()[i], 0.03, 0.01))
        << "scan " << i;
  }
}

/// How far off the track is at most when the wheels say this of each step.
void expect_on_track_with(const std::function<Pose2(const Pose2&)>& wheels) {
  FrontEnd front_end({}, {}, {});
  Rng rng(5);
  Pose2 odometry;
  for (std::size_t i = 0; i < drive().size(); ++i) {
    if (i > 0) odometry = odometry * wheels(drive()[i - 1].inverse() * drive()[i]);
    const auto tracked = front_end.add(scan_at(i, 0.01, rng), kMount, OdometryReading{odometry});
    ASSERT_TRUE(pose_near(tracked.local_T_robot, drive()[0].inverse() * drive()[i], 0.05, 0.02))
        << "scan " << i;
  }
  EXPECT_FALSE(front_end.odometry_check().episodes().empty());
}

TEST(FrontEnd, WrongWheelsDoNotDragTheLaserAlong) {
  expect_on_track_with([](const Pose2&) { return Pose2{}; });
  expect_on_track_with([](const Pose2& step) { return Pose2{step.x, step.y, -step.yaw}; });
  expect_on_track_with([](const Pose2& step) {
    return Pose2{1.8 * step.x, 1.8 * step.y, 1.8 * step.yaw};
  });
  expect_on_track_with([](const Pose2& step) { return Pose2{-step.x, step.y, step.yaw}; });
}

TEST(FrontEnd, OdometryThatIsIgnoredDoesNotMatter) {
  const FrontEndOptions ignoring{.odometry = OdometryUse::kIgnore};
  FrontEnd without(ignoring, {}, {});
  FrontEnd with(ignoring, {}, {});
  Rng rng(6);
  for (std::size_t i = 0; i < 60; ++i) {
    const LaserScan scan = scan_at(i, 0.01, rng);
    const Pose2 nonsense{0.7 * static_cast<double>(i), -3.0, 0.3 * static_cast<double>(i)};
    EXPECT_EQ(without.add(scan, kMount, {}).local_T_robot,
              with.add(scan, kMount, OdometryReading{nonsense}).local_T_robot);
  }
}

TEST(FrontEnd, AScanThatContradictsTheMapStaysOutOfIt) {
  FrontEnd front_end({}, {}, {});
  Rng rng(7);
  for (std::size_t i = 0; i < 60; ++i) {
    const bool is_strange = i >= 40 && i < 43;
    LaserScan scan = scan_at(i, 0.0, rng);
    // A ball of people close around the robot.
    if (is_strange) {
      for (std::size_t beam = 0; beam < scan.ranges_m.size(); ++beam)
        scan.ranges_m[beam] = 0.4F + 0.1F * static_cast<float>(beam % 7 < 3);
    }
    const auto tracked = front_end.add(scan, kMount, OdometryReading{drive()[i]});
    EXPECT_FALSE(is_strange && tracked.key) << "scan " << i;
    EXPECT_TRUE(pose_near(tracked.local_T_robot, drive()[0].inverse() * drive()[i], 0.05, 0.02))
        << "scan " << i;
  }
}

/// Scan after scan shows something else from the 40th on: the floor, where the robot leans. What
/// the front end says of the drive until the 70th.
std::vector<TrackedScan> through_strange_scans(FrontEnd& front_end, std::size_t strange_until,
                                               bool wheels_turn) {
  std::vector<TrackedScan> tracked;
  Rng rng(7);
  for (std::size_t i = 0; i < 70; ++i) {
    const bool is_strange = i >= 40 && i < strange_until;
    LaserScan scan = scan_at(i, 0.0, rng);
    if (is_strange) std::ranges::fill(scan.ranges_m, 0.7F);
    OdometryReading odometry{drive()[is_strange && !wheels_turn ? 40 : i]};
    odometry.path_m = 0.1 * static_cast<double>(is_strange && !wheels_turn ? 40 : i);
    tracked.push_back(front_end.add(scan, kMount, odometry));
  }
  return tracked;
}

TEST(FrontEnd, OdometryLeadsOnThroughScansThatContradictTheMap) {
  FrontEnd front_end({}, {}, {});
  const auto tracked = through_strange_scans(front_end, 60, true);
  for (std::size_t i = 40; i < tracked.size(); ++i) {
    EXPECT_FALSE(i < 60 && tracked[i].key) << "scan " << i;
    EXPECT_TRUE(pose_near(tracked[i].local_T_robot, drive()[0].inverse() * drive()[i], 0.05, 0.02))
        << "scan " << i;
    if (tracked[i].path_break) {
      EXPECT_EQ(tracked[i].path_break->bridge, BreakBridge::kLaser) << "the map is the same";
    }
  }
  EXPECT_EQ(tracked.back().tracking, TrackingStatus::kTracked);
}

/// A hall whose end no beam reaches: a wall on the right, shelves on the left.
test::Walls hall() {
  std::vector<test::Walls> places{{{{-20.0, -3.0}, {80.0, -3.0}}}};
  for (const double x : {1.0, 5.0, 9.0, 14.5, 22.0})
    places.push_back(test::rectangle({x, 3.0}, {x + 0.4, 6.0}));
  return test::together(places);
}

/// What a laser sees of it that leans so that its beams meet the floor ahead.
LaserScan hall_scan(double x, double floor_ahead_m) {
  const Scanner scanner{
      .angle_increment_rad = 0.017453292519943295, .beams = 271, .range_max_m = 12.0};
  LaserScan scan = test::scan_from(hall(), {x, 0.0, 0.0}, kMount, scanner);
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double along = std::cos(scan.angle_rad(i));
    if (along < 0.64) continue;
    scan.ranges_m[i] = std::min(scan.ranges_m[i], static_cast<float>(floor_ahead_m / along));
  }
  return scan;
}

TEST(FrontEnd, TheFloorThatALeaningLaserSeesDoesNotHoldTheRobot) {
  FrontEnd front_end({}, {}, {});
  constexpr double kStep = 0.07;
  int contested = 0;
  for (int i = 0; i < 190; ++i) {
    const double x = kStep * i;
    const bool leans = x > 8.0 && x < 12.0;
    LaserScan scan = hall_scan(x, leans ? 8.0 : 1e3);
    scan.stamp = stamp_at(static_cast<std::size_t>(i));
    OdometryReading odometry{Pose2{x, 0.0, 0.0}};
    odometry.path_m = x;
    const auto tracked = front_end.add(scan, kMount, odometry);
    ASSERT_TRUE(pose_near(tracked.local_T_robot, {x, 0.0, 0.0}, 0.08, 0.02)) << "at " << x;
    if (tracked.path_break) {
      ASSERT_EQ(tracked.path_break->bridge, BreakBridge::kLaser) << "the map is the same";
    }
    const auto taken_out = std::ranges::count(tracked.taken_out, true);
    EXPECT_TRUE(leans || taken_out <= 30) << taken_out << " beams at " << x;
    if (taken_out > 30) ++contested;
  }
  EXPECT_GT(contested, 20) << "the floor is left out where it would hold the robot";
  EXPECT_LT(contested, 50) << "but not where laser and odometry agree";
  EXPECT_TRUE(front_end.odometry_check().episodes().empty()) << "odometry was right";
}

TEST(FrontEnd, WheelsThatSlipWhileTheLaserLeansAreOutvoted) {
  FrontEnd front_end({}, {}, {});
  Pose2 odom_T_robot;
  for (int i = 0; i < 160; ++i) {
    const double x = 0.07 * i;
    if (i > 0) odom_T_robot = odom_T_robot * Pose2{0.07, 0.0, 0.0};
    if (i == 125) odom_T_robot = odom_T_robot * Pose2{0.1, 0.0, 0.06};
    LaserScan scan = hall_scan(x, i >= 125 && i < 130 ? 8.0 : 1e3);
    scan.stamp = stamp_at(static_cast<std::size_t>(i));
    OdometryReading odometry{odom_T_robot};
    odometry.path_m = x;
    const auto tracked = front_end.add(scan, kMount, odometry);
    ASSERT_TRUE(pose_near(tracked.local_T_robot, {x, 0.0, 0.0}, 0.05, 0.02)) << "at " << x;
  }
}

TEST(FrontEnd, WheelsThatSlipAreStillOutvoted) {
  FrontEnd front_end({}, {}, {});
  Pose2 odom_T_robot;
  double path_m = 0.0;
  for (std::size_t i = 0; i < drive().size(); ++i) {
    if (i > 0) odom_T_robot = odom_T_robot * (drive()[i - 1].inverse() * drive()[i]);
    if (i > 0) path_m += (drive()[i - 1].inverse() * drive()[i]).translation().norm();
    if (i == drive().size() - 10) odom_T_robot = odom_T_robot * Pose2{0.12, 0.0, 0.15};
    LaserScan scan = test::scan_from(test::furnished_room(), drive()[i], kMount, {});
    scan.stamp = stamp_at(i);
    OdometryReading odometry{odom_T_robot};
    odometry.path_m = path_m;
    const auto tracked = front_end.add(scan, kMount, odometry);
    ASSERT_TRUE(pose_near(tracked.local_T_robot, drive()[0].inverse() * drive()[i], 0.05, 0.02))
        << "scan " << i;
  }
}

TEST(FrontEnd, ARobotWhoseWheelsStandMayBeCarriedMeanwhile) {
  FrontEnd front_end({}, {}, {});
  const auto tracked = through_strange_scans(front_end, 60, false);
  const auto broken = std::ranges::find_if(
      tracked, [](const TrackedScan& scan) { return scan.path_break.has_value(); });
  ASSERT_NE(broken, tracked.end());
  EXPECT_LT(broken - tracked.begin(), 50) << "nobody waits for what shows another place";
  EXPECT_EQ(broken->path_break->bridge, BreakBridge::kNothing);
}

TEST(FrontEnd, ASlowSweepIsStraightenedByTheMotionThatTheLaserSaw) {
  // The robot starts to spin at once: the first prediction, to stand still, bends the sweep by 0.1
  // rad.
  FrontEnd front_end({}, {}, {});
  const Pose2 place{3.0, 2.5, 0.2};
  const double rate_rad_s = 1.0;
  for (int i = 0; i < 30; ++i) {
    const double turned = i < 10 ? 0.0 : 0.1 * rate_rad_s * (i - 9);
    const Pose2 world_T_robot = place * Pose2{0.0, 0.0, turned};
    const Tangent2 velocity(0.0, 0.0, i < 10 ? 0.0 : rate_rad_s);
    const Scanner scanner{.time_increment_s = 0.09 / 540.0};
    auto scan =
        test::scan_from(test::furnished_room(), world_T_robot, kMount, scanner, nullptr, velocity);
    scan.stamp = stamp_at(static_cast<std::size_t>(i));
    const auto tracked = front_end.add(scan, kMount, {});
    ASSERT_TRUE(pose_near(tracked.local_T_robot, Pose2{0.0, 0.0, turned}, 0.02, 0.01))
        << "scan " << i;
  }
}

}  // namespace
}  // namespace loopstone
