// The whole pipeline on simulated worlds, whose truth is known, and on recorded logs, whose
// relations are.

#include <gtest/gtest.h>

#include <optional>
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

/// Accepted closures that are off by more than 0.3 m or 6 deg in a direction that they claim to
/// know.
int false_closures(const MapResult& result, const SimulatedLog& log) {
  int wrong = 0;
  for (const LoopClosure& closure : result.loop_closures) {
    if (!closure.stands()) continue;
    const auto truth_at = [&](NodeId node) {
      return *log.truth.at_clamped(result.node_stamps[static_cast<std::size_t>(node.index)]);
    };
    const Pose2 error =
        (truth_at(closure.from).inverse() * truth_at(closure.to)).inverse() * closure.from_T_to;
    const double known_m = 3.0 * std::sqrt(closure.covariance.topLeftCorner<2, 2>().trace());
    if (std::hypot(error.x, error.y) > std::max(0.3, known_m) || std::abs(error.yaw) > 0.1) ++wrong;
  }
  return wrong;
}

TEST(MappingSimulated, OfficeIsCentimetreAccurate) {
  const double duration_s = small_scale() ? 60.0 : 0.0;
  SimulationOptions options{.duration_s = duration_s};
  options.laser.rate_hz = 5.0;
  const SimulatedLog log = simulate_log("office", 11, options);
  const MapResult result = map_of(log);
  EXPECT_TRUE(as_usual(ate_rmse_m(result.trajectory, log), 0.0020));
  EXPECT_EQ(false_closures(result, log), 0);
  if (small_scale()) return;
  EXPECT_GT(result.statistics.loop_closures_accepted, 20);
  EXPECT_LT(10.0 * ate_rmse_m(result.trajectory, log), ate_rmse_m(result.odometry, log));
}

TEST(MappingSimulated, AnOldScannerWithFewBeamsWillDo) {
  SimulationOptions options{.duration_s = small_scale() ? 60.0 : 300.0, .odometry_poses = true};
  options.laser.rate_hz = 5.0;
  options.laser.beams = 181;
  options.laser.fov_rad = kPi;
  const SimulatedLog log = simulate_log("office", 12, options);
  const MapResult result = map_of(log);
  EXPECT_TRUE(as_usual(ate_rmse_m(result.trajectory, log), 0.0041));
  EXPECT_EQ(false_closures(result, log), 0);
}

TEST(MappingSimulated, PeopleWalkingAboutDoNotMatter) {
  SimulationOptions options{.duration_s = small_scale() ? 40.0 : 200.0, .people = 8};
  options.laser.rate_hz = 5.0;
  const SimulatedLog log = simulate_log("office", 13, options);
  EXPECT_TRUE(as_usual(ate_rmse_m(map_of(log).trajectory, log), 0.0017));
}

TEST(MappingSimulated, ACorridorIsNoWorseThanItsOdometry) {
  SimulationOptions options{};
  options.laser.rate_hz = small_scale() ? 2.0 : 5.0;
  const SimulatedLog log = simulate_log("corridor", 3, options);
  const MapResult result = map_of(log);
  EXPECT_LT(ate_rmse_m(result.trajectory, log), ate_rmse_m(result.odometry, log));
  EXPECT_GT(result.statistics.degenerate_travel_m, 0.2 * result.statistics.path_length_m);
  EXPECT_FALSE(result.warnings.empty());
}

TEST(MappingSimulated, RoomsThatLookAlikeAreNotTakenForEachOther) {
  SimulationOptions options{.duration_s = small_scale() ? 60.0 : 400.0};
  options.laser.rate_hz = 5.0;
  const SimulatedLog log = simulate_log("rooms", 5, options);
  const MapResult result = map_of(log);
  EXPECT_EQ(false_closures(result, log), 0);
  EXPECT_TRUE(as_usual(ate_rmse_m(result.trajectory, log), 0.0020));
}

TEST(MappingSimulated, TheVerdictTellsARightMapFromASpoiledOne) {
  if (small_scale()) GTEST_SKIP() << "needs the whole drive";
  SimulationOptions options{.odometry_poses = true};
  options.laser.beams = 180;
  options.laser.fov_rad = radians(179.0);
  options.laser.rate_hz = 5.0;
  const SimulatedLog log = simulate_log("office", 11, options);
  const MapResult right = map_of(log);
  ASSERT_TRUE(as_usual(ate_rmse_m(right.trajectory, log), 0.0048));
  EXPECT_EQ(right.verdict.overall, Verdict::kGood) << right.verdict.sentence;
  // The adjustment would find most of what the loops would have told.
  const MapResult spoiled = map_of(log, {.loop_closure = false, .adjustment = {.enabled = false}});
  ASSERT_GT(ate_rmse_m(spoiled.trajectory, log), 0.08) << "much more between two visits";
  EXPECT_EQ(spoiled.verdict.overall, Verdict::kBad) << spoiled.verdict.sentence;
  EXPECT_GT(spoiled.quality.places_in_trouble(), 10 * right.quality.places_in_trouble());
}

TEST(MappingSimulated, MoreLapsOfTheSameWayKeepNoMore) {
  if (small_scale()) GTEST_SKIP() << "needs whole laps";
  const auto after = [](int laps) {
    SimulationOptions options{};
    options.laser.rate_hz = 4.0;
    options.laser.beams = 271;
    options.drive.laps = laps;
    const SimulatedLog log = simulate_log("office", 5, options);
    const MapResult result = map_of(log);
    EXPECT_TRUE(as_usual(ate_rmse_m(result.trajectory, log), 0.0036)) << laps << " laps";
    EXPECT_EQ(false_closures(result, log), 0);
    return result;
  };
  const MapResult one = after(1);
  const MapResult three = after(3);
  ASSERT_GT(three.statistics.key_scans, 2 * one.statistics.key_scans);
  EXPECT_LT(2 * three.graph.poses.size(), 3 * one.graph.poses.size())
      << "of a lap more, a key scan every 4 m stays";
}

TEST(MappingSimulated, ThreadsDoNotChangeTheResultDeterministically) {
  SimulationOptions options{.duration_s = small_scale() ? 40.0 : 150.0};
  options.laser.rate_hz = 5.0;
  options.laser.beams = 361;
  const SimulatedLog log = simulate_log("office", 14, options);
  const MapResult one = map_of(log, {}, Threads{1});
  const MapResult four = map_of(log, {}, Threads{4});
  ASSERT_EQ(one.trajectory.size(), four.trajectory.size());
  for (std::size_t i = 0; i < one.trajectory.size(); ++i) {
    ASSERT_EQ(one.trajectory.poses()[i].pose, four.trajectory.poses()[i].pose) << "scan " << i;
  }
  EXPECT_EQ(one.map.log_odds.cells(), four.map.log_odds.cells());
  EXPECT_EQ(one.loop_closures.size(), four.loop_closures.size());
}

/// Relations error of a recorded log; nothing when it is not there.
std::optional<RelationsError> relations_of_map(const std::string& name) {
  const std::string path = recorded_data("carmen/" + name + ".clf");
  const std::string relations = recorded_data("carmen/" + name + ".relations");
  if (path.empty() || relations.empty()) return {};
  const auto log = open_log(path);
  Mapper mapper(log->robot({}), {}, {});
  while (const auto message = log->next()) mapper.add(*message);
  return relations_error(mapper.finish().trajectory, read_relations(relations));
}

TEST(MappingRecorded, IntelIsGloballyConsistent) {
  if (small_scale()) GTEST_SKIP() << "LOOPSTONE_TEST_SCALE=small leaves the long logs out";
  const auto error = relations_of_map("intel");
  if (!error) GTEST_SKIP() << "carmen/intel is not among the recorded data; set LOOPSTONE_DATA";
  EXPECT_EQ(error->pairs, 2984);
  EXPECT_TRUE(as_usual(error->translation_m.mean, 0.0148));
  EXPECT_TRUE(as_usual(degrees(error->rotation_rad.mean), 0.219));
}

TEST(MappingRecorded, AcesIsGloballyConsistent) {
  if (small_scale()) GTEST_SKIP() << "LOOPSTONE_TEST_SCALE=small leaves the long logs out";
  const auto error = relations_of_map("aces");
  if (!error) GTEST_SKIP() << "carmen/aces is not among the recorded data; set LOOPSTONE_DATA";
  EXPECT_EQ(error->pairs, 1279);
  EXPECT_TRUE(as_usual(error->translation_m.mean, 0.0355));
  EXPECT_TRUE(as_usual(degrees(error->rotation_rad.mean), 0.303));
}

}  // namespace
}  // namespace loopstone::test
