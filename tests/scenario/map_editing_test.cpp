// Maps edited by hand, on simulated worlds with truth: what is right makes them better, what is
// wrong worse, and either is said.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "loopstone/slam/map_editor.hpp"
#include "mapped_drives.hpp"
#include "support/usual_figure.hpp"

namespace loopstone::test {
namespace {

MapEditor editor_of(const SimulatedLog& log, const MapOptions& options = {}) {
  Mapper mapper(log.robot, options, {});
  for (const auto& message : log.messages) mapper.add(message);
  return MapEditor(mapper.settle());
}

SimulatedLog drive(const std::string& world, std::uint64_t seed, double duration_s, int people = 0,
                   int beams = 271) {
  SimulationOptions options{.duration_s = duration_s, .people = people};
  options.laser.beams = beams;
  return simulate_log(world, seed, options);
}

double ate_of(const MapEditor& editor, const SimulatedLog& log) {
  return ate_rmse_m(editor.draw().result.trajectory, log);
}

PathPlace at(const KeyScan& key) { return {.stamp = key.stamp}; }

/// Two moments of a drive, and how far the robot was from where it had been.
struct Visit {
  std::size_t from = 0;
  std::size_t to = 0;
};

/// Pairs of key scans at one place by the truth, facing alike, with much path between them; some,
/// spread over the drive.
std::vector<Visit> visits_of(const std::vector<KeyScan>& keys, const Trajectory& truth) {
  constexpr double kBetween_s = 40.0;
  constexpr std::size_t kEvery = 15;
  std::vector<Visit> visits;
  for (std::size_t to = kEvery; to < keys.size(); to += kEvery) {
    const Pose2 there = *truth.at_clamped(keys[to].stamp);
    std::optional<std::size_t> best;
    double nearest_m = 0.7;
    for (std::size_t from = 0; from < to; ++from) {
      if ((keys[to].stamp - keys[from].stamp).seconds() < kBetween_s) break;
      const Pose2 apart = truth.at_clamped(keys[from].stamp)->inverse() * there;
      if (apart.translation().norm() >= nearest_m || std::abs(apart.yaw) > 0.6) continue;
      nearest_m = apart.translation().norm();
      best = from;
    }
    if (best) visits.push_back({*best, to});
  }
  return visits;
}

/// A ring of bare corridors: without its closures the ends do not meet.
const SimulatedLog& ring_drive() {
  static const SimulatedLog log = drive("loops", 2, 0.0, 0, 181);
  return log;
}

TEST(MapEditing, WithoutTheRightClosuresTheMapIsWorseAndUndoingMendsIt) {
  MapEditor editor = editor_of(ring_drive());
  const Trajectory before = editor.draw().result.trajectory;
  const double closed_m = ate_rmse_m(before, ring_drive());
  const EditPreview found = editor.preview();
  const auto nodes = std::ranges::count_if(found.closures, &LoopClosure::stands);
  ASSERT_GT(nodes, 0);
  for (const LoopClosure& closure : found.closures) {
    if (!closure.stands()) continue;
    const EditReport& report =
        editor.add({.what = DeleteClosure{.from = {.node = closure.from.index},
                                          .to = {.node = closure.to.index}}});
    ASSERT_TRUE(report.applied) << report.told;
  }
  EXPECT_GT(editor.preview().shift.largest_m, 0.1);
  EXPECT_GT(ate_of(editor, ring_drive()), 2.0 * closed_m);
  while (editor.undo()) {
  }
  const Trajectory after = editor.draw().result.trajectory;
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i)
    ASSERT_EQ(after.poses()[i].pose, before.poses()[i].pose);
}

TEST(MapEditing, ClosuresAddedByHandDoWhatTheMapperWouldHaveDone) {
  const double closed_m = ate_rmse_m(map_of(ring_drive()).trajectory, ring_drive());
  MapEditor editor = editor_of(ring_drive(), {.loop_closure = false});
  const double open_m = ate_of(editor, ring_drive());
  ASSERT_GT(open_m, 2.0 * closed_m);
  const std::vector<KeyScan> keys = editor.map().chain.keys();
  const std::vector<Visit> visits = visits_of(keys, ring_drive().truth);
  ASSERT_GE(visits.size(), 2U);
  int added = 0;
  for (const Visit& visit : visits) {
    // Somebody who looks at the map sees that both are one place, and about how they lie.
    const Pose2 apart = ring_drive().truth.at_clamped(keys[visit.from].stamp)->inverse() *
                        *ring_drive().truth.at_clamped(keys[visit.to].stamp);
    const Pose2 guess{apart.x + 0.3, apart.y - 0.3, apart.yaw + 0.05};
    added += editor.add({.what = AddClosure{.from = at(keys[visit.from]),
                                            .to = at(keys[visit.to]),
                                            .guess_from_T_to = guess}})
                     .applied
                 ? 1
                 : 0;
  }
  EXPECT_GE(added, 2);
  const double edited_m = ate_of(editor, ring_drive());
  EXPECT_LT(edited_m, 0.5 * open_m);
  EXPECT_LT(edited_m, 2.0 * closed_m);
}

TEST(MapEditing, ARoomThatLooksLikeAnotherIsRefusedAndForcedMakesABadMap) {
  const SimulatedLog rooms = drive("rooms", 3, small_scale() ? 120.0 : 200.0);
  MapEditor editor = editor_of(rooms);
  const MapVerdict before = editor.draw().result.verdict;
  const std::vector<KeyScan> keys = editor.map().chain.keys();
  // Where the robot was a quarter and three quarters of the way, in rooms that are alike: the same
  // pose in another one.
  std::optional<Visit> alike;
  for (std::size_t to = keys.size() / 2; to < keys.size() && !alike; to += 10) {
    const Pose2 there = *rooms.truth.at_clamped(keys[to].stamp);
    for (std::size_t from = 0; from + 100 < to && !alike; from += 10) {
      const Pose2 apart = rooms.truth.at_clamped(keys[from].stamp)->inverse() * there;
      if (apart.translation().norm() > 5.0 && apart.translation().norm() < 12.0) alike = {from, to};
    }
  }
  ASSERT_TRUE(alike.has_value());
  AddClosure wrong{.from = at(keys[alike->from]),
                   .to = at(keys[alike->to]),
                   .guess_from_T_to = Pose2{0.0, 0.0, 0.0}};
  const EditReport refused = editor.add({.what = wrong});
  EXPECT_FALSE(refused.applied) << refused.told;
  editor.undo();
  wrong.force = true;
  const EditReport forced = editor.add({.what = wrong});
  ASSERT_TRUE(forced.applied) << forced.told;
  EXPECT_EQ(forced.verdict, Verdict::kBad);
  EXPECT_EQ(editor.draw().result.verdict.overall, Verdict::kBad);
  EXPECT_NE(before.overall, Verdict::kBad);
}

TEST(MapEditing, AStretchWithPeopleIsLeftOutAndTheMapStaysRight) {
  const SimulatedLog crowd = drive("office", 21, small_scale() ? 70.0 : 140.0, 10);
  MapEditor editor = editor_of(crowd);
  const MapResult before = editor.draw().result;
  const EditReport& report =
      editor.add({.what = IgnoreStretch{.from = {.drive_s = 20.0}, .to = {.drive_s = 45.0}}});
  ASSERT_TRUE(report.applied) << report.told;
  const MapResult after = editor.draw().result;
  EXPECT_EQ(after.trajectory.size(), before.trajectory.size());
  EXPECT_TRUE(as_usual(ate_rmse_m(after.trajectory, crowd), 0.0035));
  // What only these scans saw is not on the map.
  const auto seen = [](const MapResult& result) {
    return std::ranges::count(result.map.observed.cells(), std::uint8_t{1});
  };
  EXPECT_LT(seen(after), seen(before));
}

}  // namespace
}  // namespace loopstone::test
