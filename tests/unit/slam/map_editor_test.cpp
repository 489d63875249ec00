// A finished map in somebody's hand: what each edit does, and that a map is that of its list.

#include "loopstone/slam/map_editor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/slam/settled_map.hpp"
#include "loopstone/slam/wall_axes.hpp"
#include "ring_world.hpp"
#include "support/saved_state.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

using test::state_of;
using testing::HasSubstr;

/// Twice around a block. The robot begins turned against the walls, so the map is, too.
const std::vector<SensorMessage>& recording() {
  static const std::vector<SensorMessage> result = [] {
    const Pose2 world_T_ring{2.0, -1.0, radians(20.0)};
    const test::Walls ring = test::moved(world_T_ring, test::ring());
    std::vector<Pose2> poses = test::drive_through({{1.5, 1.5},
                                                    {12.5, 1.5},
                                                    {12.5, 8.5},
                                                    {1.5, 8.5},
                                                    {1.5, 1.6},
                                                    {12.4, 1.6},
                                                    {12.4, 8.4},
                                                    {1.6, 8.4},
                                                    {1.6, 2.5}},
                                                   0.15, 0.2);
    const test::Scanner scanner{
        .angle_increment_rad = radians(2.0), .beams = 136, .range_max_m = 15.0, .noise_m = 0.01};
    Rng rng(2);
    std::vector<SensorMessage> messages;
    Pose2 odometry;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const Stamp stamp{static_cast<std::int64_t>(i + 1) * 100'000'000};
      const Pose2 pose = world_T_ring * poses[i];
      if (i > 0) {
        const Pose2 step = poses[i - 1].inverse() * poses[i];
        odometry = odometry * Pose2{1.02 * step.x, 0.0, step.yaw + 0.001};
      }
      auto scan = test::scan_from(ring, pose, {0.1, 0.0, 0.0}, scanner, &rng);
      scan.stamp = stamp;
      scan.robot_T_lidar = Pose2{0.1, 0.0, 0.0};
      messages.emplace_back(OdometryPose{stamp, odometry});
      messages.emplace_back(std::move(scan));
    }
    return messages;
  }();
  return result;
}

MapOptions options(bool loop_closure = true) {
  MapOptions options;
  options.front_end.submap_length_m = 4.0;
  options.map.resolution_m = 0.1;
  options.loop_closure = loop_closure;
  return options;
}

void feed(Mapper& mapper) {
  for (const SensorMessage& message : recording()) mapper.add(message);
}

SettledMap settled(bool loop_closure) {
  Mapper mapper(RobotModel{}, options(loop_closure), Threads{1});
  feed(mapper);
  return mapper.settle();
}

/// An editor of the map; settling it once is enough.
MapEditor editor_of(bool loop_closure = true, int threads = 1) {
  static const SettledMap closed = settled(true);
  static const SettledMap open = settled(false);
  return MapEditor(loop_closure ? closed : open, Threads{threads});
}

/// All of a result that is not a time.
std::string bytes_of(const MapResult& result) {
  std::string bytes =
      state_of(result.node_stamps, result.graph, result.loop_closures, result.map.log_odds,
               result.map.observed, result.statistics.graph_cost, result.statistics.path_length_m);
  for (const Trajectory* trajectory : {&result.trajectory, &result.odometry}) {
    for (const StampedPose2& pose : trajectory->poses()) bytes += state_of(pose.stamp, pose.pose);
  }
  for (const std::string& warning : result.warnings) bytes += warning;
  return bytes + result.verdict.sentence;
}

PathPlace at_node(std::size_t node) { return {.node = static_cast<std::int64_t>(node)}; }

/// The first closure that stands, to be deleted.
MapEdit deletion(const MapEditor& editor) {
  const EditPreview preview = editor.preview();
  const auto closure = std::ranges::find_if(preview.closures, &LoopClosure::stands);
  EXPECT_NE(closure, preview.closures.end());
  return {.what = DeleteClosure{.from_submap = closure->from_submap.index,
                                .to_submap = closure->to_submap.index}};
}

/// All of them.
std::vector<MapEdit> deletions(const MapEditor& editor) {
  std::vector<MapEdit> edits;
  for (const LoopClosure& closure : editor.preview().closures) {
    if (!closure.stands()) continue;
    edits.push_back(
        {.what = DeleteClosure{.from = at_node(static_cast<std::size_t>(closure.from.index)),
                               .to = at_node(static_cast<std::size_t>(closure.to.index))}});
  }
  return edits;
}

MapEdit crop_box(double min_x, double min_y, double max_x, double max_y) {
  return {.what = CropMap{box_polygon({min_x, min_y}, {max_x, max_y})}};
}

TEST(MapEditor, WithoutEditsItIsTheMapOfTheRun) {
  Mapper mapper(RobotModel{}, options(), Threads{1});
  feed(mapper);
  const MapResult run = mapper.finish();
  ASSERT_GE(run.statistics.loop_closures_accepted, 2);
  EXPECT_EQ(bytes_of(editor_of().draw().result), bytes_of(run));
}

TEST(MapEditor, ThreadsMakeNoDifference) {
  std::string bytes[2];
  for (const int threads : {1, 3}) {
    MapEditor editor = editor_of(true, threads);
    editor.add(deletion(editor));
    editor.add({.what = StraightenMap{}});
    editor.add({.what = IgnoreStretch{.from = {.drive_s = 5.0}, .to = {.drive_s = 8.0}}});
    bytes[threads == 1 ? 0 : 1] = bytes_of(editor.draw().result);
  }
  EXPECT_EQ(bytes[0], bytes[1]);
}

TEST(MapEditor, UndoingGivesTheSameBytes) {
  MapEditor editor = editor_of();
  const std::string before = bytes_of(editor.draw().result);
  const std::vector<MapEdit> edits = deletions(editor);
  for (const MapEdit& edit : edits) EXPECT_TRUE(editor.add(edit).applied);
  const std::string without = bytes_of(editor.draw().result);
  EXPECT_NE(without, before);
  // One by one or all at once.
  MapEditor other = editor_of();
  other.set_edits(edits);
  EXPECT_EQ(bytes_of(other.draw().result), without);
  while (editor.undo()) {
  }
  EXPECT_EQ(bytes_of(editor.draw().result), before);
  other.set_edits({});
  EXPECT_EQ(bytes_of(other.draw().result), before);
  EXPECT_FALSE(editor.undo());
}

TEST(MapEditor, ADeletedClosureIsOutAndTheRestIsSolvedAnew) {
  MapEditor editor = editor_of();
  const int stood =
      static_cast<int>(std::ranges::count_if(editor.preview().closures, &LoopClosure::stands));
  const EditReport report = editor.add(deletion(editor));
  ASSERT_TRUE(report.applied) << report.told;
  ASSERT_TRUE(report.closure.has_value());
  EXPECT_EQ(report.closure->reason, ClosureReason::kDeletedByHand);
  EXPECT_GT(report.shift.largest_m, 0.0);
  EXPECT_LE(report.shift.mean_m, report.shift.largest_m);
  const MapResult result = editor.draw().result;
  EXPECT_EQ(result.statistics.loop_closures_accepted, stood - 1);
  // There is nothing left to delete there.
  const EditReport& again = editor.add(editor.edit(0));
  EXPECT_FALSE(again.applied);
  EXPECT_THAT(again.told, HasSubstr("deleted by hand"));
  EXPECT_EQ(bytes_of(editor.draw().result), bytes_of(result));
}

TEST(MapEditor, WithoutClosuresThePathIsAsTheFrontEndHasIt) {
  MapEditor editor = editor_of();
  editor.set_edits(deletions(editor));
  ASSERT_FALSE(editor.any_refused());
  const EditPreview preview = editor.preview();
  EXPECT_EQ(preview.graph_quality.closures, 0);
  const std::vector<KeyScan> keys = editor.map().chain.keys();
  const std::vector<Pose2>& poses = editor.draw().result.graph.poses;
  ASSERT_EQ(poses.size(), keys.size());
  // The surfaces that visits share move it a little.
  const Pose2 way = keys.front().local_T_robot.inverse() * keys.back().local_T_robot;
  const Pose2 drawn = preview.map_T_keys.front().inverse() * preview.map_T_keys.back();
  EXPECT_NEAR((way.translation() - drawn.translation()).norm(), 0.0, 0.1);
}

/// A pair of nodes of the two laps at nearly the same place, far apart along the path.
std::pair<std::size_t, std::size_t> same_place(const MapEditor& editor) {
  const std::vector<Pose2>& poses = editor.map_T_keys();
  const std::size_t from = poses.size() / 8;
  std::size_t best = poses.size() / 3;
  for (std::size_t i = poses.size() / 3; i < poses.size(); ++i) {
    if ((poses[i].translation() - poses[from].translation()).norm() <
        (poses[best].translation() - poses[from].translation()).norm())
      best = i;
  }
  return {from, best};
}

TEST(MapEditor, AClosureThatWasMissedCanBeAdded) {
  MapEditor editor = editor_of(false);
  const auto [from, to] = same_place(editor);
  const EditReport report = editor.add(
      {.what = AddClosure{.from = at_node(from), .to = at_node(to), .half_window_m = 1.5}});
  ASSERT_TRUE(report.applied) << report.told;
  ASSERT_TRUE(report.closure.has_value());
  EXPECT_EQ(report.closure->reason, ClosureReason::kAddedByHand);
  EXPECT_GT(report.closure->overlap, 0.5);
  EXPECT_GT(report.closure->agreement, 0.75);
  EXPECT_EQ(editor.draw().result.statistics.loop_closures_accepted, 1);
  // It is as near to the map that found its closures itself as scans are to one another.
  const Trajectory closed = editor_of().draw().result.trajectory;
  const std::vector<KeyScan> keys = editor.map().chain.keys();
  const Pose2 found =
      closed.at_clamped(keys[from].stamp)->inverse() * *closed.at_clamped(keys[to].stamp);
  EXPECT_NEAR((report.closure->from_T_to.translation() - found.translation()).norm(), 0.0, 0.05);
  // The other way round it is the same.
  MapEditor other = editor_of(false);
  (void)other.add(
      {.what = AddClosure{.from = at_node(to), .to = at_node(from), .half_window_m = 1.5}});
  EXPECT_EQ(bytes_of(other.draw().result), bytes_of(editor.draw().result));
}

TEST(MapEditor, WhatDoesNotFitIsRefusedWithItsFigures) {
  MapEditor editor = editor_of();
  const std::string before = bytes_of(editor.draw().result);
  const std::size_t nodes = editor.map_T_keys().size();
  // Two sides of the block.
  const MapEdit wrong{.what = AddClosure{.from = at_node(nodes / 10),
                                         .to = at_node(nodes / 3),
                                         .guess_from_T_to = Pose2{0.0, 0.0, 0.0}}};
  const EditReport report = editor.add(wrong);
  EXPECT_FALSE(report.applied);
  EXPECT_THAT(report.told, testing::AnyOf(HasSubstr("score"), HasSubstr("agreement")));
  EXPECT_EQ(report.shift.largest_m, 0.0);
  EXPECT_TRUE(editor.any_refused());
  EXPECT_EQ(bytes_of(editor.draw().result), before);
  // Who insists gets it, and a map that says what it is worth.
  editor.undo();
  MapEdit forced = wrong;
  std::get<AddClosure>(forced.what).force = true;
  const EditReport& insisted = editor.add(forced);
  EXPECT_TRUE(insisted.applied) << insisted.told;
  EXPECT_GT(insisted.shift.largest_m, 0.0);
  EXPECT_EQ(insisted.verdict, Verdict::kBad);
  EXPECT_EQ(editor.draw().result.verdict.overall, Verdict::kBad);
}

TEST(MapEditor, NeighboursOnThePathNeedNoClosure) {
  MapEditor editor = editor_of();
  const EditReport& report =
      editor.add({.what = AddClosure{.from = at_node(20), .to = at_node(24)}});
  EXPECT_FALSE(report.applied);
  EXPECT_THAT(report.told, HasSubstr("neighbours"));
}

TEST(MapEditor, PlacesBesideThePathAreRefused) {
  MapEditor editor = editor_of();
  EXPECT_THAT(editor.add({.what = AddClosure{.from = at_node(0), .to = at_node(1'000'000)}}).told,
              HasSubstr("there is no node"));
  EXPECT_THAT(
      editor.add({.what = IgnoreStretch{.from = {.drive_s = 1.0}, .to = {.drive_s = 1e5}}}).told,
      HasSubstr("no moment of the path"));
  EXPECT_FALSE(editor.report(0).applied);
}

TEST(MapEditor, AnIgnoredStretchIsNotDrawnAndInNoClosure) {
  MapEditor editor = editor_of();
  const MapResult before = editor.draw().result;
  const double from_s = 3.0;
  const double to_s = 9.0;
  const EditReport report =
      editor.add({.what = IgnoreStretch{.from = {.drive_s = from_s}, .to = {.drive_s = to_s}}});
  ASSERT_TRUE(report.applied);
  const MapResult after = editor.draw().result;
  // The path stays, and is still told.
  EXPECT_EQ(after.trajectory.size(), before.trajectory.size());
  EXPECT_EQ(after.graph.poses.size(), before.graph.poses.size());
  EXPECT_NE(state_of(after.map.log_odds), state_of(before.map.log_odds));
  // What is ignored from its first scan to its last is in no closure at all.
  editor.undo();
  const Stamp last = editor.map().track.back().stamp;
  const EditReport all =
      editor.add({.what = IgnoreStretch{.from = {.drive_s = 0.0}, .to = {.stamp = last}}});
  ASSERT_TRUE(all.applied);
  EXPECT_TRUE(std::ranges::none_of(editor.preview().closures, &LoopClosure::stands));
}

TEST(MapEditor, AStraightenedMapIsTheSameMapTurned) {
  MapEditor editor = editor_of();
  const MapResult before = editor.draw().result;
  const EditReport report = editor.add({.what = StraightenMap{}});
  ASSERT_TRUE(report.applied) << report.told;
  EXPECT_THAT(report.told, HasSubstr(" deg"));
  EXPECT_EQ(report.shift.largest_m, 0.0);  // of the graph: nothing
  const EditedMap straight = editor.draw();
  const MapResult& after = straight.result;
  const auto first = before.trajectory.poses();
  const auto second = after.trajectory.poses();
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    const Pose2 expected = straight.new_T_map * first[i].pose;
    EXPECT_NEAR((expected.translation() - second[i].pose.translation()).norm(), 0.0, 1e-9);
  }
  EXPECT_NEAR(after.statistics.graph_cost, before.statistics.graph_cost, 1e-6);
  // The drive began along a wall: the map is nearly straight already. Turned by hand first, it
  // comes back.
  for (const double yaw_deg : {-40.0, 12.0, 44.0}) {
    MapEditor turned = editor_of();
    turned.add({.what = SetOrigin{.point = {1.0, 2.0}, .yaw_rad = radians(yaw_deg)}});
    turned.add({.what = MapAsEdited{}});
    turned.add({.what = StraightenMap{}});
    ASSERT_FALSE(turned.any_refused());
    const Pose2 new_T_map = turned.draw().new_T_map;
    EXPECT_NEAR(degrees(std::remainder(new_T_map.yaw - straight.new_T_map.yaw, 0.5 * kPi)), 0.0,
                0.2)
        << yaw_deg;
  }
  // A second time there is nothing to do.
  EXPECT_FALSE(editor.add({.what = StraightenMap{}}).applied);
}

TEST(MapEditor, CovariancesTurnWithTheMap) {
  MapEditor editor = editor_of();
  const MapResult before = editor.draw().result;
  editor.add({.what = SetOrigin{.point = {0.0, 0.0}, .yaw_rad = 0.5 * kPi}});
  const MapResult after = editor.draw().result;
  const NodeId node{static_cast<int>(before.graph.poses.size() / 2)};
  const Eigen::Matrix3d was = before.covariances.of(node);
  const Eigen::Matrix3d is = after.covariances.of(node);
  EXPECT_NEAR(is(0, 0), was(1, 1), 1e-9);
  EXPECT_NEAR(is(1, 1), was(0, 0), 1e-9);
  EXPECT_NEAR(is(2, 2), was(2, 2), 1e-12);
}

TEST(MapEditor, TheOriginIsWhereItWasPut) {
  MapEditor editor = editor_of();
  const std::vector<Pose2> before = editor.draw().result.graph.poses;
  const Pose2 at = before[40];
  editor.add({.what = SetOrigin{.point = at.translation(), .yaw_rad = at.yaw}});
  const std::vector<Pose2> after = editor.draw().result.graph.poses;
  EXPECT_NEAR(after[40].translation().norm(), 0.0, 1e-9);
  EXPECT_NEAR(after[40].yaw, 0.0, 1e-9);
  const Pose2 was = before[40].inverse() * before[80];
  EXPECT_NEAR((after[80].translation() - was.translation()).norm(), 0.0, 1e-9);
  EXPECT_THAT(editor.add({.what = SetOrigin{}}).told, HasSubstr("already"));
  EXPECT_THAT(editor.add({.what = StraightenMap{}}).told, HasSubstr("leave out one"));
}

TEST(MapEditor, TheOrderOfFrameAndPolygonsMakesNoDifference) {
  const std::vector<MapEdit> edits{
      crop_box(-1.0, -1.0, 6.0, 9.0),
      {.what = StraightenMap{}},
      {.what = SetOrigin{.point = {2.0, 1.0}}},
      {.what = KeepOut{.name = "k", .polygon = box_polygon({1.0, 1.0}, {2.0, 2.0})}},
      {.what =
           LimitSpeed{.name = "s", .polygon = box_polygon({3.0, 0.0}, {5.0, 2.0}), .limit = 40.0}}};
  MapEditor one = editor_of();
  one.set_edits(edits);
  MapEditor other = editor_of();
  other.set_edits(std::vector<MapEdit>(edits.rbegin(), edits.rend()));
  ASSERT_FALSE(one.any_refused());
  ASSERT_FALSE(other.any_refused());
  const EditedMap a = one.draw();
  const EditedMap b = other.draw();
  EXPECT_EQ(bytes_of(a.result), bytes_of(b.result));
  ASSERT_EQ(a.keep_out.size(), 1U);
  EXPECT_EQ(a.keep_out[0].polygon, b.keep_out[0].polygon);
  // Zones and frame move together: the corner that was (1, 1) is where the frame says.
  const Eigen::Vector2d expected = a.new_T_map * Eigen::Vector2d(1.0, 1.0);
  EXPECT_NEAR((a.keep_out[0].polygon.corners[0] - expected).norm(), 0.0, 1e-9);
  EXPECT_EQ(a.speed[0].limit, 40.0);
}

TEST(MapEditor, PolygonsFollowTheirPartOfTheMap) {
  MapEditor editor = editor_of();
  // Around the robot's place on its second lap, and told so; and another one, held by the first.
  const auto [first, second] = same_place(editor);
  const Eigen::Vector2d at = editor.map_T_keys()[second].translation();
  const Polygon2 polygon =
      box_polygon(at - Eigen::Vector2d(0.5, 0.5), at + Eigen::Vector2d(0.5, 0.5));
  const std::vector<MapEdit> closures = deletions(editor);
  editor.add({.what = KeepOut{.polygon = polygon}, .anchor = at_node(second)});
  editor.add({.what = KeepOut{.polygon = polygon}, .anchor = at_node(first)});
  const EditPreview before = editor.preview();
  EXPECT_NEAR((before.polygons[0].corners[0] - polygon.corners[0]).norm(), 0.0, 1e-9);
  for (const MapEdit& edit : closures) ASSERT_TRUE(editor.add(edit).applied);
  const EditPreview after = editor.preview();
  const EditedMap drawn = editor.draw();
  for (const auto& [place, node] : {std::pair{std::size_t{0}, second}, {std::size_t{1}, first}}) {
    // Each is where its key scan is, in shape and place.
    const Polygon2 expected =
        drawn.result.graph.poses[node] * (editor.map_T_keys()[node].inverse() * polygon);
    for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
      EXPECT_NEAR((drawn.keep_out[place].polygon.corners[i] - expected.corners[i]).norm(), 0.0,
                  1e-9);
      EXPECT_NEAR((after.polygons[place].corners[i] - expected.corners[i]).norm(), 0.0, 0.05);
    }
  }
  // The two laps have parted, and so have the zones.
  EXPECT_GT((after.polygons[0].corners[0] - after.polygons[1].corners[0]).norm(), 1e-3);
}

TEST(MapEditor, WhatFollowsIsToldOnTheMapAsEdited) {
  MapEditor editor = editor_of();
  editor.add({.what = SetOrigin{.point = {3.0, 1.0}, .yaw_rad = 0.3}});
  editor.add({.what = MapAsEdited{}});
  editor.add({.what = KeepOut{.polygon = box_polygon({0.0, 0.0}, {1.0, 1.0})}});
  ASSERT_FALSE(editor.any_refused());
  const EditedMap edited = editor.draw();
  EXPECT_NEAR(edited.keep_out[0].polygon.corners[0].norm(), 0.0, 1e-9);
  EXPECT_NEAR((edited.new_T_map * Eigen::Vector2d(3.0, 1.0)).norm(), 0.0, 1e-9);
}

TEST(MapEditor, CroppedAndErasedAreWhatLiesThere) {
  MapEditor editor = editor_of();
  const MapResult before = editor.draw().result;
  editor.add({.what = EraseInside{box_polygon({-1.0, -3.0}, {4.0, 3.0})}});
  const EditedMap erased = editor.draw();
  EXPECT_GT(erased.cells_erased, 10);
  EXPECT_EQ(erased.result.map.observed.cells(), before.map.observed.cells());
  // Not along the borders of cells, where rounding decides which ones it touches.
  editor.add(crop_box(0.05, -1.95, 5.05, 2.05));
  const MapResult cropped = editor.draw().result;
  EXPECT_LE(cropped.map.observed.frame().columns, 51);
  EXPECT_LT(cropped.map.observed.cells().size(), before.map.observed.cells().size());
  // A drawing is of scans, not of an older drawing.
  while (editor.undo()) {
  }
  EXPECT_EQ(bytes_of(editor.draw().result), bytes_of(before));
}

TEST(MapEditor, SpeedsAreToldInOneWay) {
  MapEditor editor = editor_of();
  const Polygon2 polygon = box_polygon({0.0, 0.0}, {1.0, 1.0});
  editor.add({.what = LimitSpeed{.polygon = polygon, .limit = 30.0}});
  EXPECT_THAT(editor
                  .add({.what = LimitSpeed{.polygon = polygon,
                                           .limit = 0.3,
                                           .unit = SpeedUnit::kMetresPerSecond}})
                  .told,
              HasSubstr("all told in percent"));
}

}  // namespace
}  // namespace loopstone
