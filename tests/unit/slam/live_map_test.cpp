#include "loopstone/slam/live_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "loopstone/geometry/angle.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

constexpr double kFootprintM = 0.25;
constexpr std::size_t kScansEach = 8;

/// A drive through a furnished room, cut into submaps.
MapSnapshot drive() {
  MapSnapshot snapshot;
  const auto poses =
      test::drive_through({{1.0, 1.0}, {5.5, 1.2}, {5.0, 4.0}, {1.5, 4.5}}, 0.2, 0.2);
  const test::Scanner scanner{
      .angle_increment_rad = radians(1.0), .beams = 271, .range_max_m = 20.0};
  std::shared_ptr<MappedScans> scans;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const bool starts = i % kScansEach == 0;
    auto mapped = std::make_shared<MappedScan>(
        MappedScan{.scan = test::scan_from(test::furnished_room(), poses[i], {}, scanner),
                   .index = i,
                   .local_T_robot = poses[i],
                   .local_T_robot_end = poses[i],
                   .is_key = starts});
    if (starts) {
      scans = std::make_shared<MappedScans>();
      snapshot.submaps.push_back({.id = {snapshot.submaps.size()},
                                  .state = SubmapState::kFrozen,
                                  .map_T_submap = poses[i],
                                  .scans = scans});
    }
    scans->push_back(std::move(mapped));
  }
  return snapshot;
}

/// The drive up to so many scans.
MapSnapshot first_scans(const MapSnapshot& whole, std::size_t count) {
  MapSnapshot part;
  for (SubmapSnapshot submap : whole.submaps) {
    if (count == 0) break;
    auto scans = std::make_shared<MappedScans>(*submap.scans);
    scans->resize(std::min(scans->size(), count));
    count -= scans->size();
    submap.scans = scans;
    part.submaps.push_back(submap);
  }
  return part;
}

void expect_as_drawn_at_once(const LiveMap& live, const MapSnapshot& snapshot) {
  LiveMap fresh({}, kFootprintM);
  fresh.refresh(snapshot, LiveMap::kNoLimit);
  const OccupancyMap a = live.map();
  const OccupancyMap b = fresh.map();
  ASSERT_EQ(a.log_odds.frame(), b.log_odds.frame());
  EXPECT_EQ(a.log_odds.cells(), b.log_odds.cells());
  EXPECT_EQ(a.observed.cells(), b.observed.cells());
}

std::size_t scan_count(const MapSnapshot& snapshot) {
  std::size_t count = 0;
  for (const SubmapSnapshot& submap : snapshot.submaps) count += submap.scans->size();
  return count;
}

/// As a closure does it: by more, the older a submap.
void move_all(MapSnapshot& snapshot) {
  for (std::size_t i = 0; i < snapshot.submaps.size(); ++i) {
    const double share = 0.1 * static_cast<double>(i + 1);
    snapshot.submaps[i].map_T_local = {share, -0.5 * share, 0.3 * share};
  }
}

/// Returns how many calls it took.
std::size_t refresh_until_current(LiveMap& live, const MapSnapshot& snapshot, std::size_t limit) {
  std::size_t calls = 0;
  do {
    live.refresh(snapshot, limit);
    ++calls;
  } while (!live.is_current() && calls < 100'000);
  EXPECT_TRUE(live.is_current());
  EXPECT_EQ(live.submaps_waiting(), 0U);
  return calls;
}

TEST(LiveMap, NothingIsNothing) {
  LiveMap live({}, kFootprintM);
  EXPECT_EQ(live.refresh({}), 0U);
  EXPECT_TRUE(live.is_current());
  EXPECT_TRUE(live.tiles_since(0).empty());
}

TEST(LiveMap, ScanByScanItBecomesTheMapOfAll) {
  const MapSnapshot whole = drive();
  LiveMap live({}, kFootprintM);
  for (std::size_t count = 1; count < 30; ++count) {
    EXPECT_GT(live.refresh(first_scans(whole, count)), 0U);
    EXPECT_EQ(live.refresh(first_scans(whole, count)), 0U) << "nothing is new";
  }
  live.refresh(whole);
  expect_as_drawn_at_once(live, whole);
}

TEST(LiveMap, WhatMovesIsDrawnAnewAndTheRestStays) {
  MapSnapshot snapshot = drive();
  // Its first submap stands far off, in a place of its own.
  snapshot.submaps[0].map_T_local = {100.0, 0.0, 0.0};
  LiveMap live({}, kFootprintM);
  live.refresh(snapshot);
  const std::int64_t before = live.revision();
  snapshot.submaps[2].map_T_local = {0.3, -0.2, 0.1};
  EXPECT_GT(live.refresh(snapshot), 0U);
  expect_as_drawn_at_once(live, snapshot);
  for (const OccupancyTile& tile : live.tiles_since(before)) EXPECT_LT(tile.id.column, 10);
  EXPECT_GT(live.tiles_since(0).size(), live.tiles_since(before).size());
}

TEST(LiveMap, EverythingMovesWhileScansCome) {
  const MapSnapshot whole = drive();
  LiveMap live({}, kFootprintM);
  MapSnapshot last;
  for (std::size_t step = 1; step <= 5; ++step) {
    last = first_scans(whole, 7 * step);
    for (std::size_t i = 0; i < last.submaps.size(); ++i) {
      const double share = 0.1 * static_cast<double>(step * i);
      last.submaps[i].map_T_local = {share, -0.5 * share, 0.3 * share};
    }
    live.refresh(last);
  }
  expect_as_drawn_at_once(live, last);
}

TEST(LiveMap, AHairsBreadthIsNoMove) {
  MapSnapshot snapshot = drive();
  LiveMap live({}, kFootprintM);
  live.refresh(snapshot);
  for (SubmapSnapshot& submap : snapshot.submaps) submap.map_T_local = {0.002, -0.001, 0.0001};
  EXPECT_EQ(live.refresh(snapshot), 0U);
  for (SubmapSnapshot& submap : snapshot.submaps) submap.map_T_local = {0.02, 0.0, 0.0};
  EXPECT_GT(live.refresh(snapshot), 0U);
}

TEST(LiveMap, ThinnedScansAreTakenOffTheMap) {
  MapSnapshot snapshot = drive();
  LiveMap live({}, kFootprintM);
  live.refresh(snapshot);
  snapshot.submaps[1].scans = std::make_shared<MappedScans>(1, snapshot.submaps[1].scans->front());
  EXPECT_GT(live.refresh(snapshot), 0U);
  expect_as_drawn_at_once(live, snapshot);
}

TEST(LiveMap, LimitedItTakesMoreCallsToTheSameTiles) {
  const MapSnapshot before = drive();
  MapSnapshot after = before;
  move_all(after);
  const std::size_t scans = scan_count(before);
  for (const std::size_t limit : {std::size_t{1}, std::size_t{7}, std::size_t{50}}) {
    LiveMap live({}, kFootprintM);
    // What is drawn once costs a scan each; what moves is looked at, then drawn.
    EXPECT_GE(refresh_until_current(live, before, limit), scans / limit);
    expect_as_drawn_at_once(live, before);
    EXPECT_GE(refresh_until_current(live, after, limit), 2 * scans / limit);
    expect_as_drawn_at_once(live, after);
  }
}

TEST(LiveMap, WithoutALimitOneCallIsEnough) {
  MapSnapshot snapshot = drive();
  LiveMap live({}, kFootprintM);
  EXPECT_EQ(refresh_until_current(live, snapshot, LiveMap::kNoLimit), 1U);
  move_all(snapshot);
  EXPECT_EQ(refresh_until_current(live, snapshot, LiveMap::kNoLimit), 1U);
  expect_as_drawn_at_once(live, snapshot);
}

TEST(LiveMap, TilesStayAsTheyWereUntilAllOfThemAreDrawn) {
  const MapSnapshot before = drive();
  MapSnapshot after = before;
  move_all(after);
  LiveMap live({}, kFootprintM);
  live.refresh(before);
  // As many as all have: they are redrawn together, and looking at them takes the first call.
  const std::size_t limit = scan_count(before);
  EXPECT_EQ(live.refresh(after, limit), 0U);
  EXPECT_FALSE(live.is_current());
  EXPECT_EQ(live.submaps_waiting(), after.submaps.size());
  expect_as_drawn_at_once(live, before);
  EXPECT_GT(live.refresh(after, limit), 0U);
  EXPECT_TRUE(live.is_current());
  expect_as_drawn_at_once(live, after);
}

TEST(LiveMap, WhatIsNearTheRobotComesFirst) {
  MapSnapshot snapshot = drive();
  const auto far_off = [](double x) { return Pose2{100.0 + x, 0.0, 0.0}; };
  for (std::size_t i = 0; i < 2; ++i) snapshot.submaps[i].map_T_local = far_off(0.0);
  LiveMap live({}, kFootprintM);
  live.refresh(snapshot);
  const std::int64_t before = live.revision();
  for (std::size_t i = 0; i < snapshot.submaps.size(); ++i)
    snapshot.submaps[i].map_T_local = i < 2 ? far_off(0.3) : Pose2{0.3, 0.0, 0.0};
  const auto far_tiles = [&] {
    std::size_t count = 0;
    for (const OccupancyTile& tile : live.tiles_since(before)) count += tile.id.column > 10 ? 1 : 0;
    return count;
  };
  while (live.refresh(snapshot, 2 * kScansEach) == 0) {
  }
  EXPECT_FALSE(live.is_current());
  EXPECT_EQ(far_tiles(), 0U);
  refresh_until_current(live, snapshot, 2 * kScansEach);
  EXPECT_GT(far_tiles(), 0U);
  expect_as_drawn_at_once(live, snapshot);
}

TEST(LiveMap, NewScansDoNotWaitForWhatMoved) {
  const MapSnapshot whole = drive();
  const std::size_t count = scan_count(whole);
  LiveMap live({}, kFootprintM);
  live.refresh(first_scans(whole, count - 4));
  const std::int64_t before = live.revision();
  MapSnapshot after = whole;
  move_all(after);
  EXPECT_GT(live.refresh(after, kScansEach), 0U);
  EXPECT_FALSE(live.is_current());
  const SubmapSnapshot& newest = after.submaps.back();
  const Eigen::Vector2d robot =
      (newest.map_T_local * newest.scans->back()->local_T_robot).translation();
  const double side_m = OccupancyTile::kSide * live.resolution_m();
  const TileId at{static_cast<int>(std::floor(robot.x() / side_m)),
                  static_cast<int>(std::floor(robot.y() / side_m))};
  EXPECT_TRUE(std::ranges::any_of(live.tiles_since(before),
                                  [&](const OccupancyTile& tile) { return tile.id == at; }));
  refresh_until_current(live, after, kScansEach);
  expect_as_drawn_at_once(live, after);
}

TEST(LiveMap, LimitedItFollowsWhateverHappensMeanwhile) {
  const MapSnapshot whole = drive();
  LiveMap live({}, kFootprintM);
  MapSnapshot last;
  for (std::size_t step = 1; step <= 8; ++step) {
    last = first_scans(whole, 5 * step);
    for (std::size_t i = 0; i < last.submaps.size(); ++i) {
      const double share = 0.1 * static_cast<double>(step * i);
      last.submaps[i].map_T_local = {share, -0.5 * share, 0.3 * share};
    }
    if (step > 5)
      last.submaps[1].scans = std::make_shared<MappedScans>(1, last.submaps[1].scans->front());
    live.refresh(last, 6);
    EXPECT_FALSE(live.is_current() && step > 2);
  }
  refresh_until_current(live, last, 6);
  expect_as_drawn_at_once(live, last);
}

}  // namespace
}  // namespace loopstone
