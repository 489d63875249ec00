// What goes wrong on robots, on simulated worlds whose truth is known: the map stays right, and the
// run says what it was.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "loopstone/evaluation/relations.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/relations_file.hpp"
#include "loopstone/geometry/angle.hpp"
#include "mapped_drives.hpp"
#include "support/recorded_data.hpp"
#include "support/usual_figure.hpp"

namespace loopstone::test {
namespace {

/// 180 beams and the base's own dead reckoning, as old logs have them; or all beams, counts and
/// gyro.
SimulatedLog office_with(const SimulatedFaults& faults, bool poses = true, int people = 0) {
  SimulationOptions options{
      .duration_s = small_scale() ? 60.0 : 150.0, .people = people, .odometry_poses = poses};
  options.laser.beams = 271;
  options.faults = faults;
  return simulate_log("office", 21, options);
}

bool warns_of(const MapResult& result, const std::string& words) {
  return std::any_of(
      result.warnings.begin(), result.warnings.end(),
      [&](const std::string& warning) { return warning.find(words) != std::string::npos; });
}

using Fault = SimulatedOdometryFault;

struct FaultCase {
  Fault fault;
  std::string warning;
};

class RobustTo : public testing::TestWithParam<FaultCase> {};

TEST_P(RobustTo, TheMapStaysRightAndTheRunSaysWhy) {
  const SimulatedLog log = office_with({.odometry = GetParam().fault});
  const MapResult result = map_of(log);
  EXPECT_TRUE(as_usual(ate_rmse_m(result.trajectory, log), 0.0026));
  if (GetParam().warning.empty()) {
    EXPECT_FALSE(warns_of(result, "odometry"));
  } else {
    EXPECT_TRUE(warns_of(result, GetParam().warning));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Odometry, RobustTo,
    testing::Values(FaultCase{Fault::kNone, ""},
                    FaultCase{Fault::kMissing, "no odometry in the log"},
                    FaultCase{Fault::kStuck, "stands still while the robot drives"},
                    FaultCase{Fault::kScaled, "times the true one"},
                    FaultCase{Fault::kMirrored, "turn opposite ways"},
                    FaultCase{Fault::kLagging, "s late"},
                    FaultCase{Fault::kJumping, "odometry jumped"}),
    [](const auto& named) { return std::string(to_string(named.param.fault)); });

TEST(Robustness, HealthyOdometryIsNotAccused) {
  for (const std::string world : {"office", "rooms", "warehouse"}) {
    for (std::uint64_t seed = 1; seed <= (small_scale() ? 1 : 3); ++seed) {
      SimulationOptions options{.duration_s = 100.0, .odometry_poses = seed % 2 == 0};
      options.laser.beams = 181;
      options.laser.rate_hz = 5.0;
      const MapResult result = map_of(simulate_log(world, seed, options), {.loop_closure = false});
      EXPECT_TRUE(result.odometry_episodes.empty()) << world << " " << seed;
      EXPECT_EQ(result.statistics.odometry_jumps, 0) << world << " " << seed;
    }
  }
}

// A room seen askew shows as many strangers as a crowd would.
TEST(Robustness, AJumpOfOdometryIsNoCrowd) {
  SimulationOptions options{.duration_s = 30.0, .odometry_poses = true};
  options.laser.beams = 181;
  options.laser.fov_rad = kPi;
  options.faults = {.odometry = Fault::kJumping};
  double largest_m = 0.0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SimulatedLog log = simulate_log("rooms", seed, options);
    const MapResult result = map_of(log);
    EXPECT_TRUE(result.laser_episodes.empty()) << seed;
    largest_m = std::max(largest_m, ate_rmse_m(result.trajectory, log));
  }
  EXPECT_TRUE(as_usual(largest_m, 0.0025));
}

// Along bare walls nothing else tells that the robot drives.
TEST(Robustness, PeopleWhoWalkAlongACorridorDoNotAccuseOdometry) {
  SimulationOptions options{.duration_s = 60.0};
  options.laser.beams = 541;
  choose_realism(options.realism, "usual,crowd");
  for (const std::uint64_t seed : {240U, 270U}) {
    const SimulatedLog log = simulate_log("corridor", seed, options);
    const MapResult result = map_of(log);
    EXPECT_TRUE(result.odometry_episodes.empty()) << seed;
    EXPECT_TRUE(warns_of(result, "people stood about it")) << seed;
    // Nor do they hold it back; of the other one two gaps of its odometry are open.
    if (seed != 240U) continue;
    EXPECT_TRUE(as_usual(ate_rmse_m(result.trajectory, log), 0.12));
  }
}

TEST(Robustness, OdometryOfAnotherClockIsReadAtItsOwnTime) {
  // 0.75 s apart in the end, as those of cheap oscillators are after a few hours.
  SimulationOptions options{.duration_s = small_scale() ? 100.0 : 250.0, .odometry_poses = true};
  options.laser.beams = 181;
  options.laser.rate_hz = 5.0;
  SimulatedLog log = simulate_log("office", 3, options);
  const Stamp begin = stamp_of(log.messages.front());
  for (SensorMessage& message : log.messages) {
    auto* pose = std::get_if<OdometryPose>(&message);
    if (pose == nullptr) continue;
    const double passed_s = (pose->stamp - begin).seconds();
    pose->stamp = pose->stamp + Duration::from_seconds(0.003 * passed_s);
  }
  std::ranges::stable_sort(log.messages, {},
                           [](const SensorMessage& message) { return stamp_of(message); });
  const MapResult result = map_of(log);
  EXPECT_TRUE(as_usual(ate_rmse_m(result.trajectory, log), 0.006));
  EXPECT_TRUE(warns_of(result, "from then on it is read so much later"));
  EXPECT_FALSE(warns_of(result, "it was not used"));
  ASSERT_FALSE(result.odometry_episodes.empty());
  double late_s = 0.0;
  for (const OdometryEpisode& episode : result.odometry_episodes) {
    EXPECT_EQ(episode.fault, OdometryFault::kLagging);
    EXPECT_TRUE(episode.over);
    late_s += episode.lag_s;
  }
  EXPECT_NEAR(late_s, 0.003 * options.duration_s, 0.3);
}

TEST(Robustness, AGyroAloneGivesTheHeading) {
  const SimulatedLog log = office_with({.odometry = Fault::kMissing}, false);
  const MapResult result = map_of(log);
  EXPECT_TRUE(as_usual(ate_rmse_m(result.trajectory, log), 0.0025));
  EXPECT_TRUE(warns_of(result, "the gyro tells the heading"));
  EXPECT_TRUE(result.odometry.empty());
}

TEST(Robustness, OdometryThatHasBecomeRightIsUsedAgain) {
  const SimulatedLog log = office_with({.odometry = Fault::kStuck, .from_s = 20.0, .to_s = 50.0});
  const MapResult result = map_of(log);
  EXPECT_TRUE(as_usual(ate_rmse_m(result.trajectory, log), 0.0024));
  ASSERT_FALSE(result.odometry_episodes.empty());
  const Stamp start = result.trajectory.front().stamp;
  for (const OdometryEpisode& episode : result.odometry_episodes) {
    EXPECT_GT((episode.from - start).seconds(), 15.0);
    if (!small_scale()) {
      EXPECT_TRUE(episode.over);
      EXPECT_GT((episode.to - start).seconds(), 48.0);
    }
  }
}

TEST(Robustness, LostScansPeopleAndGlassTogether) {
  for (const bool with_odometry : {true, false}) {
    const SimulatedLog log =
        office_with({.scans_dropped = 0.3, .glass = 0.15}, false, small_scale() ? 3 : 8);
    MapOptions options;
    if (!with_odometry) options.front_end.odometry = OdometryUse::kIgnore;
    EXPECT_TRUE(as_usual(ate_rmse_m(map_of(log, options).trajectory, log), 0.0033))
        << with_odometry;
  }
}

/// Something hangs before the laser for a while and lets some beams through.
TEST(Robustness, ALaserThatIsCoveredInPartIsHeldByTheRest) {
  for (const double seen_share : {0.25, 0.5, 0.7}) {
    SimulationOptions options{.duration_s = small_scale() ? 70.0 : 150.0};
    options.laser.beams = 181;
    options.laser.rate_hz = 5.0;
    options.realism.blocked.on = true;
    options.realism.blocked.at_s = 30.0;
    options.realism.blocked.length_s = 30.0;
    options.realism.blocked.seen_share = seen_share;
    const SimulatedLog log = simulate_log("office", 23, options);
    const MapResult result = map_of(log);
    EXPECT_TRUE(as_usual(ate_rmse_m(result.trajectory, log), 0.0076)) << seen_share;
    EXPECT_TRUE(warns_of(result, "covered in part") || warns_of(result, "was blocked"))
        << seen_share;
  }
}

TEST(Robustness, ACrowdThatGoesWithTheRobotIsNotMapped) {
  SimulationOptions options{.duration_s = small_scale() ? 70.0 : 150.0};
  options.laser.beams = 271;
  options.laser.rate_hz = 5.0;
  options.realism.crowd.on = true;
  options.realism.crowd.from_s = 25.0;
  options.realism.crowd.to_s = 55.0;
  const SimulatedLog log = simulate_log("office", 24, options);
  const MapResult result = map_of(log);
  EXPECT_TRUE(as_usual(ate_rmse_m(result.trajectory, log), 0.0096));
  EXPECT_TRUE(warns_of(result, "people stood about it"));
}

TEST(Robustness, AFastTurningRobotNeedsNoOdometry) {
  SimulationOptions options{.duration_s = small_scale() ? 40.0 : 120.0};
  options.drive.yaw_rate_rad_s = 3.0;
  options.drive.speed_m_s = 1.0;
  options.laser.beams = 541;
  const SimulatedLog log = simulate_log("office", 22, options);
  MapOptions laser_only;
  laser_only.front_end.odometry = OdometryUse::kIgnore;
  EXPECT_TRUE(as_usual(ate_rmse_m(map_of(log, laser_only).trajectory, log), 0.0024));
}

TEST(Robustness, WheelsThatAreTooLargeAreCorrectedAlongACorridor) {
  SimulationOptions options{};
  options.laser.rate_hz = small_scale() ? 2.0 : 5.0;
  options.laser.beams = 361;
  const SimulatedLog log = simulate_log("corridor", 3, options);
  MapOptions trusting;
  trusting.front_end.odometry = OdometryUse::kTrust;
  const MapResult result = map_of(log);
  EXPECT_TRUE(as_usual(
      ate_rmse_m(result.trajectory, log) / ate_rmse_m(map_of(log, trusting).trajectory, log),
      small_scale() ? 0.65 : 0.127));
  EXPECT_NEAR(result.statistics.odometry_translation_scale, 0.985, 0.01);
}

TEST(Robustness, StandingStillAddsNothing) {
  SimulationOptions options{.duration_s = 90.0};
  options.drive.standstill_s = 60.0;
  options.laser.beams = 181;
  const SimulatedLog log = simulate_log("office", 23, options);
  for (const OdometryUse odometry : {OdometryUse::kCheck, OdometryUse::kIgnore}) {
    Mapper mapper(log.robot, {.front_end = {.odometry = odometry}}, Threads{1});
    for (const auto& message : log.messages) {
      if ((stamp_of(message) - stamp_of(log.messages.front())).seconds() < 58.0)
        mapper.add(message);
    }
    const MapResult result = mapper.finish();
    EXPECT_EQ(result.graph.poses.size(), 1u) << to_string(odometry);
    EXPECT_EQ(result.statistics.key_scans, 1) << to_string(odometry);
  }
}

TEST(Robustness, ThreadsDoNotChangeARunWithFaults) {
  const SimulatedLog log = office_with({.odometry = Fault::kStuck, .scans_dropped = 0.2}, true, 3);
  const MapResult one = map_of(log, {}, Threads{1});
  const MapResult three = map_of(log, {}, Threads{3});
  ASSERT_EQ(one.trajectory.size(), three.trajectory.size());
  for (std::size_t i = 0; i < one.trajectory.size(); ++i)
    ASSERT_EQ(one.trajectory.poses()[i].pose, three.trajectory.poses()[i].pose) << "scan " << i;
  EXPECT_EQ(one.warnings, three.warnings);
}

/// Relations error of a recorded log mapped from the laser alone.
void expect_consistent_from_the_laser_alone(const std::string& name, double usual_m) {
  const std::string path = recorded_data("carmen/" + name + ".clf");
  const std::string relations = recorded_data("carmen/" + name + ".relations");
  if (path.empty() || relations.empty())
    GTEST_SKIP() << "carmen/" << name << " is not among the recorded data; set LOOPSTONE_DATA";
  if (small_scale()) GTEST_SKIP() << "LOOPSTONE_TEST_SCALE=small leaves the long logs out";
  const auto log = open_log(path);
  Mapper mapper(log->robot({}), {.front_end = {.odometry = OdometryUse::kIgnore}}, {});
  while (const auto message = log->next()) mapper.add(*message);
  const auto error = relations_error(mapper.finish().trajectory, read_relations(relations));
  EXPECT_TRUE(as_usual(error.translation_m.mean, usual_m));
}

TEST(RobustnessRecorded, IntelFromTheLaserAlone) {
  expect_consistent_from_the_laser_alone("intel", 0.0175);
}

TEST(RobustnessRecorded, AcesFromTheLaserAlone) {
  expect_consistent_from_the_laser_alone("aces", 0.0386);
}

TEST(RobustnessRecorded, HonestWheelsOfRealRobotsAreNotAccused) {
  if (small_scale()) GTEST_SKIP() << "LOOPSTONE_TEST_SCALE=small leaves the long logs out";
  for (const std::string name : {"intel", "aces"}) {
    const std::string path = recorded_data("carmen/" + name + ".clf");
    if (path.empty()) GTEST_SKIP() << "carmen/" << name << " is not among the recorded data";
    const auto log = open_log(path);
    Mapper mapper(log->robot({}), {.loop_closure = false}, {});
    while (const auto message = log->next()) mapper.add(*message);
    const MapResult result = mapper.finish();
    EXPECT_TRUE(result.odometry_episodes.empty()) << name;
    EXPECT_FALSE(warns_of(result, "odometry jumped")) << name;
  }
}

}  // namespace
}  // namespace loopstone::test
