#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/drive.hpp"
#include "loopstone/simulation/surface_index.hpp"
#include "loopstone/simulation/world.hpp"

namespace loopstone {
namespace {

/// Free, but for an unknown rim and a few occupied cells.
Grid<std::int8_t> cluttered_map() {
  const GridFrame frame{{-3.0, 2.0}, 0.1, 120, 80};
  Grid<std::int8_t> map(frame, 0);
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      if (row < 2 || column < 2 || row >= frame.rows - 2 || column >= frame.columns - 2) {
        map[{column, row}] = -1;
      }
    }
  }
  Rng rng(9);
  for (int i = 0; i < 25; ++i) {
    const Cell cell{static_cast<int>(rng.below(120)), static_cast<int>(rng.below(80))};
    if (map[cell] == 0) map[cell] = 100;
  }
  return map;
}

/// Ray against the cells themselves: the nearest entry into any solid cell's square.
double cast_over_cells(const Grid<std::int8_t>& map, const Eigen::Vector2d& origin,
                       const Eigen::Vector2d& direction) {
  double nearest = std::numeric_limits<double>::infinity();
  const GridFrame& frame = map.frame();
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      const Cell cell{column, row};
      if (map[cell] == 0) continue;
      const Eigen::Vector2d low = frame.origin + frame.resolution * Eigen::Vector2d(column, row);
      const Eigen::Vector2d high =
          frame.origin + frame.resolution * Eigen::Vector2d(column + 1, row + 1);
      const Eigen::Array2d a = (low - origin).array() / direction.array();
      const Eigen::Array2d b = (high - origin).array() / direction.array();
      const double enters = a.min(b).maxCoeff();
      const double leaves = a.max(b).minCoeff();
      if (enters >= 0.0 && enters <= leaves) nearest = std::min(nearest, enters);
    }
  }
  return nearest;
}

TEST(MapWorld, RangesAreExactForTheCells) {
  const Grid<std::int8_t> map = cluttered_map();
  const World world = make_world(map, "clutter", 0.25);
  const SurfaceIndex index(world.plan);
  for (int i = 0; i < 300; ++i) {
    const double yaw = 0.013 + 0.021 * i;
    const Eigen::Vector2d direction(std::cos(yaw), std::sin(yaw));
    const Eigen::Vector2d origin = world.map_T_start.translation();
    EXPECT_NEAR(index.cast(origin, direction, 50.0), cast_over_cells(map, origin, direction), 1e-9)
        << i;
  }
}

TEST(MapWorld, StartsWhereTheMapIsFreeHoweverLargeTheUnknownIs) {
  // A small room in a wide unknown plane: the plane has no surfaces in it, but nobody can drive
  // there.
  const GridFrame frame{{0.0, 0.0}, 0.1, 400, 400};
  Grid<std::int8_t> map(frame, -1);
  for (int row = 100; row < 160; ++row) {
    for (int column = 50; column < 120; ++column) map[{column, row}] = 0;
  }
  const World world = make_world(map, "room", 0.25);
  ASSERT_FALSE(world.places.empty());
  EXPECT_EQ(map[frame.cell_of(world.map_T_start.translation())], 0);
  for (const auto& place : world.places) EXPECT_EQ(map[frame.cell_of(place)], 0);
}

TEST(MapWorld, IsDrivenWithoutTouchingAnything) {
  const World world = make_world(cluttered_map(), "clutter", 0.25);
  const Drive drive = drive_route(world, 0.25);
  EXPECT_GT(drive.travelled_m(drive.duration_s()), 15.0);
  const SurfaceIndex index(world.plan);
  for (double time = 0.0; time <= drive.duration_s(); time += 0.05) {
    EXPECT_GE(index.distance(drive.pose_at(time).translation(), 1.0), 0.25)
        << "at " << time << " s";
  }
}

TEST(MapWorld, KeepsTheGivenMapAsTheTrueOne) {
  const Grid<std::int8_t> map = cluttered_map();
  const Grid<std::int8_t> truth = true_map(make_world(map, "clutter", 0.25), 0.02);
  EXPECT_EQ(truth.cells(), map.cells());
  EXPECT_EQ(truth.frame(), map.frame());
}

TEST(MapWorld, RefusesAMapWithoutRoom) {
  const GridFrame frame{{0.0, 0.0}, 0.05, 8, 8};
  const Grid<std::int8_t> map(frame, 0);
  EXPECT_THROW((void)make_world(map, "cupboard", 0.25), UsageError);
  const Grid<std::int8_t> unknown(frame, -1);
  EXPECT_THROW((void)make_world(unknown, "nothing", 0.25), UsageError);
}

}  // namespace
}  // namespace loopstone
