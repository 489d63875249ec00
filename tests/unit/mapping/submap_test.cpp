#include "loopstone/mapping/submap.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/registration/correlative_search.hpp"
#include "loopstone/registration/grid_matcher.hpp"
#include "support/pose_near.hpp"
#include "support/saved_state.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

using test::distance_to_walls;
using test::Walls;

const std::vector<Pose2>& visits() {
  static const std::vector<Pose2> poses{{4.0, 3.0, 0.0}, {4.5, 3.0, 1.5},  {5.5, 4.5, 3.0},
                                        {3.0, 2.0, 2.0}, {1.0, 1.5, -1.0}, {2.5, 3.5, 0.5}};
  return poses;
}

/// The furnished room as a submap whose frame is the first visit.
Submap submap_of_room(const SubmapOptions& options = {}) {
  const Pose2 robot_T_lidar{0.1, 0.0, 0.0};
  Submap submap(options);
  BeamTable beams;
  for (const auto& at : visits()) {
    const auto scan = test::scan_from(test::furnished_room(), at, robot_T_lidar, {});
    const auto surfaces = surface_points(scan, robot_T_lidar, Tangent2::Zero(), {}, beams);
    submap.insert(surfaces, scan, robot_T_lidar, visits().front().inverse() * at, beams);
  }
  return submap;
}

Walls room_in_submap() { return test::moved(visits().front().inverse(), test::furnished_room()); }

TEST(Submap, FreezingKeepsTheSurfaces) {
  const auto frozen = submap_of_room().freeze();
  const Walls walls = room_in_submap();
  ASSERT_GT(frozen.surfaces.size(), 150U);
  for (const auto& surface : frozen.surfaces) {
    EXPECT_LT(distance_to_walls(walls, surface.position.cast<double>()), 0.06);
    EXPECT_NEAR(surface.normal.norm(), 1.0F, 1e-4F);
    EXPECT_GT(surface.weight, 0.0F);
  }
  // Every stretch of wall that was seen is still there.
  BeamTable beams;
  const auto scan = test::scan_from(test::furnished_room(), visits().front(), {}, {});
  std::size_t missing = 0;
  const auto seen = surface_points(scan, {}, Tangent2::Zero(), {}, beams);
  for (const auto& point : seen) {
    const bool kept = std::any_of(frozen.surfaces.begin(), frozen.surfaces.end(),
                                  [&](const SurfacePoint& surface) {
                                    return (surface.position - point.position).norm() < 0.12F &&
                                           surface.normal.dot(point.normal) > 0.8F;
                                  });
    if (!kept && point.weight == 1.0F) ++missing;
  }
  EXPECT_LT(missing, seen.size() / 50);
}

TEST(Submap, FreezingThinsWhatManyScansSaw) {
  Submap submap({});
  BeamTable beams;
  const auto scan = test::scan_from(test::furnished_room(), visits().front(), {}, {});
  const auto surfaces = surface_points(scan, {}, Tangent2::Zero(), {}, beams);
  // A guess counts once a few scans agree on it.
  for (int i = 0; i < 5; ++i) submap.insert(surfaces, scan, {}, Pose2{}, beams);
  const auto soon = submap.freeze().surfaces.size();
  for (int i = 0; i < 50; ++i) submap.insert(surfaces, scan, {}, Pose2{}, beams);
  EXPECT_EQ(submap.freeze().surfaces.size(), soon);
}

TEST(Submap, FreeSpaceIsWhereBeamsPassedAndNeverOnAWall) {
  for (const double cell_m : {0.1, 0.2}) {
    const auto frozen = submap_of_room({.free_cell_m = cell_m}).freeze();
    const Walls walls = room_in_submap();
    const GridFrame& frame = frozen.free.frame();
    for (const auto& surface : frozen.surfaces) {
      EXPECT_EQ(frozen.free.value_or(frame.cell_of(surface.position.cast<double>()), 0), 0)
          << "a wall at " << surface.position.transpose() << " counts as free";
    }
    double free_m2 = 0.0;
    for (int row = 0; row < frame.rows; ++row) {
      for (int column = 0; column < frame.columns; ++column) {
        if (frozen.free[{column, row}] == 0) continue;
        free_m2 += cell_m * cell_m;
        const Eigen::Vector2d world = visits().front() * frame.centre_of({column, row});
        const bool in_room =
            world.x() > 0.0 && world.x() < 8.0 && world.y() > 0.0 && world.y() < 6.5;
        EXPECT_TRUE(in_room) << "beams do not pass through walls";
        EXPECT_FALSE(world.x() > 6.9 && world.x() < 7.3 && world.y() < 1.6) << "inside the cabinet";
      }
    }
    EXPECT_GT(free_m2, 0.85 * 47.0) << "of the floor";
  }
}

TEST(Submap, BeamsWithoutReturnFreeNoMoreThanTheBound) {
  Submap submap({.no_return_carve_m = 3.0});
  BeamTable beams;
  LaserScan scan{.angle_min_rad = -kPi, .angle_increment_rad = kPi / 90.0, .range_max_m = 30.0};
  scan.ranges_m.assign(180, std::numeric_limits<float>::infinity());
  submap.insert({}, scan, {}, Pose2{}, beams);
  auto frozen = submap.freeze();
  EXPECT_TRUE(frozen.surfaces.empty());
  EXPECT_EQ(frozen.free.value_or(frozen.free.frame().cell_of({2.5, 0.0}), 0), 1);
  EXPECT_EQ(frozen.free.value_or(frozen.free.frame().cell_of({3.5, 0.0}), 0), 0);
  // A bad beam says nothing.
  Submap blind({});
  scan.ranges_m.assign(180, std::numeric_limits<float>::quiet_NaN());
  blind.insert({}, scan, {}, Pose2{}, beams);
  EXPECT_TRUE(blind.freeze().free.empty());
}

TEST(Submap, GoesOnFromItsState) {
  Submap submap = submap_of_room();
  Submap again = test::restored(submap, Submap({}));
  EXPECT_EQ(test::state_of(again), test::state_of(submap));
  BeamTable beams;
  const Pose2 at{5.0, 2.0, 0.3};
  const auto scan = test::scan_from(test::furnished_room(), at, {}, {});
  const auto surfaces = surface_points(scan, {}, Tangent2::Zero(), {}, beams);
  for (Submap* one : {&submap, &again})
    one->insert(surfaces, scan, {}, visits().front().inverse() * at, beams);
  EXPECT_EQ(test::state_of(again.freeze()), test::state_of(submap.freeze()));
  const auto spoilt = [&](const SubmapOptions& other) {
    return test::refuses(submap, [&](Submap::State& state) { state = Submap(other).state(); });
  };
  EXPECT_FALSE(spoilt({}));
  EXPECT_TRUE(spoilt({.cell_m = 0.05}));
  EXPECT_TRUE(spoilt({.free_cell_m = 0.1}));
}

TEST(Submap, EmptyFreezesToNothingThatStillAnswers) {
  const auto frozen = Submap({}).freeze();
  EXPECT_TRUE(frozen.surfaces.empty());
  EXPECT_TRUE(frozen.probe(100).empty());
  EXPECT_FALSE(frozen.surface_grid({}).line_near(0, {0.0, 0.0}, {1.0, 0.0}).has_value());
  EXPECT_EQ(frozen.search_pyramid({}, 1.0).bound(0, 0, 0), kUnknown);
}

TEST(Submap, ProbeHasTheCountAskedForAndIsSpreadEvenly) {
  const auto frozen = submap_of_room().freeze();
  const std::size_t all = frozen.surfaces.size();
  for (const std::size_t count : {std::size_t{1}, std::size_t{10}, std::size_t{100}, all}) {
    const auto probe = frozen.probe(count);
    EXPECT_NEAR(static_cast<double>(probe.size()), static_cast<double>(count), 1.0);
    for (const auto& point : probe) {
      EXPECT_TRUE(
          std::any_of(frozen.surfaces.begin(), frozen.surfaces.end(),
                      [&](const SurfacePoint& s) { return s.position.cast<double>() == point; }));
    }
  }
  EXPECT_EQ(frozen.probe(10 * all).size(), all);
  // No wall is left out.
  const auto probe = frozen.probe(all / 4);
  for (const auto& surface : frozen.surfaces) {
    double nearest = 1e9;
    for (const auto& point : probe)
      nearest = std::min(nearest, (point - surface.position.cast<double>()).norm());
    EXPECT_LT(nearest, 1.5);
  }
}

TEST(Submap, SearchPyramidScoresTheTruthHighAndElsewhereLow) {
  const auto frozen = submap_of_room().freeze();
  const auto pyramid = frozen.search_pyramid({}, 1.0);
  const auto found =
      search_branch_and_bound(frozen.probe(300), pyramid, {{0.3, -0.2, 0.1}, 1.0, 0.3}, 0.3);
  ASSERT_TRUE(found.found);
  EXPECT_TRUE(test::pose_near(found.target_T_source, Pose2{}, 0.12, 0.03));
  EXPECT_GT(found.score, 0.6);
  const GridFrame& frame = pyramid.frame();
  for (const auto& surface : frozen.surfaces) {
    const Cell cell = frame.cell_of(surface.position.cast<double>());
    EXPECT_GT(pyramid.bound(0, cell.column, cell.row), kUnknown);
  }
  const Cell middle = frame.cell_of(visits().front().inverse() * Eigen::Vector2d(4.0, 2.0));
  EXPECT_EQ(pyramid.bound(0, middle.column, middle.row), kContradiction);
}

TEST(Submap, FrozenSurfacesAlignScansAsWellAsLiveOnes) {
  const auto submap = submap_of_room();
  const auto frozen = submap.freeze().surface_grid({});
  BeamTable beams;
  const Pose2 truth{4.3, 2.7, 0.6};
  const auto surfaces = surface_points(test::scan_from(test::furnished_room(), truth, {}, {}), {},
                                       Tangent2::Zero(), {}, beams);
  const Pose2 submap_T_robot = visits().front().inverse() * truth;
  const Pose2 guess = submap_T_robot * Pose2{0.06, -0.05, 0.04};
  const auto live = match_to_grid(surfaces, submap.surfaces(), guess, {}, {}, 1);
  const auto kept = match_to_grid(surfaces, frozen, guess, {}, {}, 1);
  EXPECT_TRUE(test::pose_near(live.target_T_source, submap_T_robot, 0.005, 0.002));
  EXPECT_TRUE(test::pose_near(kept.target_T_source, submap_T_robot, 0.015, 0.004));
}

}  // namespace
}  // namespace loopstone
