#include "loopstone/simulation/world.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "loopstone/base/error.hpp"
#include "loopstone/simulation/drive.hpp"
#include "loopstone/simulation/surface_index.hpp"

namespace loopstone {
namespace {

constexpr double kRadius = 0.25;

/// How near the drive comes to a point.
double nearest_pass(const Drive& drive, const Eigen::Vector2d& point) {
  double nearest = 1e9;
  for (double time = 0.0; time <= drive.duration_s(); time += 0.4) {
    nearest = std::min(nearest, (drive.pose_at(time).translation() - point).norm());
  }
  return nearest;
}

double free_area(const Grid<std::int8_t>& map) {
  double cells = 0.0;
  for (const std::int8_t cell : map.cells()) cells += cell == 0 ? 1.0 : 0.0;
  return cells * map.frame().resolution * map.frame().resolution;
}

/// No free cell at the grid's edge: the walls hold.
bool is_closed(const Grid<std::int8_t>& map) {
  const GridFrame& frame = map.frame();
  const auto is_free = [&](int column, int row) { return map[{column, row}] == 0; };
  for (int column = 0; column < frame.columns; ++column) {
    if (is_free(column, 0) || is_free(column, frame.rows - 1)) return false;
  }
  for (int row = 0; row < frame.rows; ++row) {
    if (is_free(0, row) || is_free(frame.columns - 1, row)) return false;
  }
  return true;
}

struct Kind {
  const char* name;
  double least_area_m2;
  double most_area_m2;
  double least_route_m;
};

class BuiltInWorld : public testing::TestWithParam<Kind> {};

TEST_P(BuiltInWorld, HasItsSizeAndIsClosed) {
  const World world = make_world(GetParam().name, 1);
  EXPECT_GE(world.floor_area_m2, GetParam().least_area_m2);
  EXPECT_LE(world.floor_area_m2, GetParam().most_area_m2);
  const Grid<std::int8_t> map = true_map(world, 0.1);
  EXPECT_TRUE(is_closed(map));
  // Walls and furniture take their share, but most of the floor is one connected free space.
  EXPECT_GT(free_area(map), 0.7 * world.floor_area_m2);
  EXPECT_LT(free_area(map), world.floor_area_m2);
}

TEST_P(BuiltInWorld, IsVisitedWithoutTouchingAnything) {
  const World world = make_world(GetParam().name, 2);
  const Drive drive = drive_route(world, kRadius);
  EXPECT_GT(drive.travelled_m(drive.duration_s()), GetParam().least_route_m);
  for (const Eigen::Vector2d& place : world.places) {
    EXPECT_LT(nearest_pass(drive, place), 0.8) << "place " << place.transpose();
  }
  for (const Eigen::Vector2d& point : world.returns) EXPECT_LT(nearest_pass(drive, point), 0.8);
  EXPECT_LT((drive.last_pose().translation() - world.returns.back()).norm(), 0.5)
      << "did not arrive";

  FloorPlan obstacles = world.plan;
  obstacles.boxes.insert(obstacles.boxes.end(), world.keep_out.begin(), world.keep_out.end());
  const SurfaceIndex index(obstacles);
  double least = 1.0;
  for (double time = 0.0; time <= drive.duration_s(); time += 0.02) {
    least = std::min(least, index.distance(drive.pose_at(time).translation(), 0.3));
  }
  EXPECT_GE(least, kRadius);
}

INSTANTIATE_TEST_SUITE_P(
    All, BuiltInWorld,
    testing::Values(Kind{"office", 950.0, 1100.0, 250.0}, Kind{"campus", 9000.0, 11000.0, 1000.0},
                    Kind{"corridor", 300.0, 400.0, 250.0}, Kind{"rooms", 1000.0, 1200.0, 250.0},
                    Kind{"warehouse", 2000.0, 2300.0, 300.0}, Kind{"loops", 200.0, 1100.0, 100.0},
                    Kind{"wings", 1500.0, 3000.0, 300.0}, Kind{"aisles", 900.0, 2000.0, 200.0},
                    Kind{"hall", 8000.0, 8000.0, 200.0}),
    [](const auto& kind) { return std::string(kind.param.name); });

TEST(World, OutdoorsIsOpenAndVisited) {
  const World world = make_world("outdoors", 2);
  EXPECT_FALSE(is_closed(true_map(world, 0.2)));
  const Drive drive = drive_route(world, kRadius);
  for (const Eigen::Vector2d& place : world.places) EXPECT_LT(nearest_pass(drive, place), 1.1);
  EXPECT_LT((drive.last_pose().translation() - world.returns.back()).norm(), 1.1);
}

TEST(World, LoopsAreOneRingOfTheirLength) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const World world = make_world("loops", seed);
    const Drive drive = drive_route(world, kRadius);
    const double way = drive.travelled_m(drive.duration_s());
    EXPECT_GT(way, 100.0) << seed;
    EXPECT_LT(way, 415.0) << seed;
    // Once round: it comes back to the start only at the end.
    double back_s = 0.0;
    for (double time = 30.0; time <= drive.duration_s() && back_s == 0.0; time += 0.2) {
      if ((drive.pose_at(time).translation() - world.map_T_start.translation()).norm() < 1.0)
        back_s = time;
    }
    EXPECT_GT(drive.travelled_m(back_s), 0.85 * way - 12.0) << seed;
  }
}

TEST(World, TheHallIsLargerThanTheLasersReach) {
  const World world = make_world("hall", 1);
  const SurfaceIndex index(world.plan);
  const Drive drive = drive_route(world, kRadius);
  std::size_t fewest = 360;
  for (double time = 0.0; time < drive.duration_s(); time += 1.0) {
    std::size_t seen = 0;
    for (int i = 0; i < 360; ++i) {
      const Eigen::Vector2d direction(std::cos(radians(i)), std::sin(radians(i)));
      seen += std::isfinite(index.cast(drive.pose_at(time).translation(), direction, 30.0)) ? 1 : 0;
    }
    fewest = std::min(fewest, seen);
  }
  EXPECT_LT(fewest, 40U);
}

TEST(World, WingsAndAislesLookAlike) {
  const World wings = make_world("wings", 1);
  const SurfaceIndex of_wings(wings.plan);
  // Both places of a wing come one after the other.
  const Eigen::Vector2d first = wings.places[0];
  const Eigen::Vector2d second = wings.places[2];
  const Eigen::Vector2d upstairs = wings.places[8];
  const World aisles = make_world("aisles", 1);
  const SurfaceIndex of_aisles(aisles.plan);
  for (int i = 0; i < 360; ++i) {
    const Eigen::Vector2d direction(std::cos(radians(i + 0.5)), std::sin(radians(i + 0.5)));
    const double range = of_wings.cast(first, direction, 12.0);
    const double other = of_wings.cast(second, direction, 12.0);
    const double above = of_wings.cast(upstairs, direction, 12.0);
    if (std::isfinite(range) || std::isfinite(other)) {
      EXPECT_NEAR(range, other, 1e-6) << i;
    }
    if (std::isfinite(range) || std::isfinite(above)) {
      EXPECT_NEAR(range, above, 1e-6) << i;
    }
    const double a = of_aisles.cast(aisles.places[1], direction, 4.0);
    const double b = of_aisles.cast(aisles.places[2], direction, 4.0);
    if (std::isfinite(a) || std::isfinite(b)) {
      EXPECT_NEAR(a, b, 1e-6) << i;
    }
  }
}

TEST(World, OfficesOfManySeedsAreVisitedWhole) {
  for (std::uint64_t seed = 10; seed < 14; ++seed) {
    const World world = make_world("office", seed);
    const Drive drive = drive_route(world, kRadius);
    for (const Eigen::Vector2d& place : world.places) {
      EXPECT_LT(nearest_pass(drive, place), 0.8)
          << "seed " << seed << ", place " << place.transpose();
    }
    EXPECT_LT((drive.last_pose().translation() - world.returns.back()).norm(), 0.5)
        << "seed " << seed;
  }
}

TEST(World, SeedsDifferAndRepeat) {
  const World one = make_world("office", 1);
  const World again = make_world("office", 1);
  const World other = make_world("office", 2);
  ASSERT_EQ(one.plan.boxes.size(), again.plan.boxes.size());
  for (std::size_t i = 0; i < one.plan.boxes.size(); ++i) {
    EXPECT_EQ(one.plan.boxes[i].map_T_box, again.plan.boxes[i].map_T_box);
  }
  EXPECT_EQ(true_map(one).cells(), true_map(again).cells());
  EXPECT_NE(one.plan.boxes.size(), other.plan.boxes.size());
}

TEST(World, RoomsOfTheSymmetricWorldLookAlike) {
  const World world = make_world("rooms", 1);
  const SurfaceIndex index(world.plan);
  // Every second place is the same spot of a neighbouring room: from two of one row the near walls
  // are equal.
  const Eigen::Vector2d first = world.places[1];
  const Eigen::Vector2d second = world.places[2];
  EXPECT_NEAR((second - first).norm(), 5.0, 1e-9);
  for (int i = 0; i < 360; ++i) {
    const Eigen::Vector2d direction(std::cos(radians(i + 0.5)), std::sin(radians(i + 0.5)));
    const double a = index.cast(first, direction, 2.0);
    const double b = index.cast(second, direction, 2.0);
    if (std::isfinite(a) || std::isfinite(b)) {
      EXPECT_NEAR(a, b, 1e-9) << i << " deg";
    }
  }
}

TEST(World, AnUnknownNameListsTheKnownOnes) {
  try {
    (void)make_world("ofice", 1);
    FAIL() << "accepted";
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("office, campus, corridor"), std::string::npos)
        << error.what();
  }
}

TEST(TrueMap, IsOccupiedAtWallsFreeInsideUnknownOutside) {
  World world;
  world.map_T_start = {1.0, 1.0, 0.0};
  for (const auto& [x, y, length, width] :
       {std::array{2.0, -0.1, 4.4, 0.2}, std::array{2.0, 3.1, 4.4, 0.2},
        std::array{-0.1, 1.5, 0.2, 3.4}, std::array{4.1, 1.5, 0.2, 3.4}}) {
    world.plan.boxes.push_back({{x, y, 0.0}, length, width});
  }
  world.plan.circles.push_back({{3.0, 2.0}, 0.015});  // thinner than a cell, on a corner of four
  const Grid<std::int8_t> map = true_map(world, 0.05);
  const GridFrame& frame = map.frame();
  const auto state = [&](double x, double y) {
    const std::int8_t cell = map[frame.cell_of({x, y})];
    return cell < 0 ? '?' : cell > 0 ? '#' : '.';
  };
  EXPECT_EQ(state(0.51, 0.51), '.');
  EXPECT_EQ(state(0.01, 1.51), '.') << "the wall's face lies on the border of this cell";
  EXPECT_EQ(state(-0.01, 1.51), '#');
  EXPECT_EQ(state(-0.1, 1.51), '#') << "walls are solid";
  EXPECT_EQ(state(-0.19, 1.51), '#');
  EXPECT_EQ(state(-0.21, 1.51), '?');
  EXPECT_EQ(state(-0.4, -0.4), '?');
  EXPECT_EQ(state(3.001, 2.001), '#') << "thin legs are not lost";
}

}  // namespace
}  // namespace loopstone
