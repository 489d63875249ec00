#include "loopstone/slam/live_map.hpp"

#include <gtest/gtest.h>

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
  fresh.refresh(snapshot);
  const OccupancyMap a = live.map();
  const OccupancyMap b = fresh.map();
  ASSERT_EQ(a.log_odds.frame(), b.log_odds.frame());
  EXPECT_EQ(a.log_odds.cells(), b.log_odds.cells());
  EXPECT_EQ(a.observed.cells(), b.observed.cells());
}

TEST(LiveMap, NothingIsNothing) {
  LiveMap live({}, kFootprintM);
  EXPECT_EQ(live.refresh({}), 0U);
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

}  // namespace
}  // namespace loopstone
