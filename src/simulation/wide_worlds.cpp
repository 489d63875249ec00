// Worlds with much room: equal aisles, a hall beyond the laser's reach, outdoors.

#include "simulation/builtin_worlds.hpp"
#include "simulation/plan_builder.hpp"

namespace loopstone {
namespace {

constexpr double kOuterWall = 0.3;

/// Two back-to-back rows of bays along x, every bay with the same two pallets.
void add_equal_rack(PlanBuilder& builder, const Eigen::Vector2d& low, int bays, double bay_m,
                    double depth_m) {
  const double length = bays * bay_m;
  builder.keep_out({low.x() + 0.5 * length, low.y() + depth_m, 0.0}, length, 2.0 * depth_m);
  for (int post = 0; post <= bays; ++post) {
    for (const double y : {0.06, depth_m - 0.06, depth_m + 0.06, 2.0 * depth_m - 0.06})
      builder.box({low.x() + post * bay_m, low.y() + y, 0.0}, 0.1, 0.1);
  }
  for (int bay = 0; bay < bays; ++bay) {
    for (int row = 0; row < 2; ++row) {
      for (const double x : {0.28, 0.72}) {
        builder.box({low.x() + (bay + x) * bay_m, low.y() + (row + 0.5) * depth_m, 0.0}, 0.8, 0.8);
      }
    }
  }
}

/// A house, with a porch at one side.
void add_house(PlanBuilder& builder, const Pose2& map_T_house, Rng& rng) {
  const double length = rng.uniform(14.0, 26.0);
  const double depth = rng.uniform(10.0, 17.0);
  builder.box(map_T_house, length, depth);
  builder.world().plan.boxes.back().is_wall = true;
  const double x = rng.uniform(-0.3, 0.3) * length;
  builder.box(map_T_house * Pose2{x, 0.5 * depth + 0.6, 0.0}, rng.uniform(2.0, 4.0), 1.4);
  for (const double side : {-1.0, 1.0})  // gutters
    builder.circle(map_T_house * Eigen::Vector2d(side * 0.5 * length, -0.5 * depth - 0.1), 0.08);
}

}  // namespace

void build_aisles(World& world, Rng rng) {
  const double bay = 2.7;
  const double rack_depth = 1.1;
  const double aisle = rng.uniform(2.5, 3.1);
  const int bays = 9 + static_cast<int>(rng.below(4));
  const int racks = 6 + static_cast<int>(rng.below(3));
  const double cross = 3.4;
  const double width = bays * bay + 2.0 * cross;
  const double depth = racks * (2.0 * rack_depth + aisle) + aisle;
  PlanBuilder builder(world, Pose2{});
  builder.shell(width, depth, kOuterWall);
  for (int rack = 0; rack < racks; ++rack) {
    const double y = aisle + rack * (2.0 * rack_depth + aisle);
    add_equal_rack(builder, {cross, y}, bays, bay, rack_depth);
    builder.place({0.5 * width, y - 0.5 * aisle});
  }
  builder.place({0.5 * width, depth - 0.5 * aisle});
  builder.start({0.5 * cross, 0.5 * aisle, 0.0});
  builder.return_to({width - 0.5 * cross, depth - 0.5 * aisle});
  builder.return_to({width - 0.5 * cross, 0.5 * aisle});
  builder.return_to({0.5 * cross, 0.5 * aisle});
}

void build_hall(World& world, Rng rng) {
  const double width = 100.0;
  const double depth = 80.0;
  PlanBuilder builder(world, Pose2{});
  builder.shell(width, depth, kOuterWall);
  const double between = rng.uniform(18.0, 24.0);
  for (double x = 0.5 * between; x < width; x += between) {
    for (double y = 0.5 * between; y < depth; y += between) builder.circle({x, y}, 0.3);
  }
  for (double x = 8.0; x < width - 8.0; x += rng.uniform(9.0, 16.0)) {  // stands along the walls
    for (const double y : {2.0, depth - 2.0}) {
      if (rng.below(2) == 0) continue;
      const double length = rng.uniform(1.0, 4.0);
      const double thickness = rng.uniform(0.6, 1.5);
      builder.box({x, y, rng.uniform(-0.2, 0.2)}, length, thickness);
    }
  }
  builder.start({4.0, 6.0, 0.0});
  for (const auto& place :
       {Eigen::Vector2d(0.5 * width, 0.5 * depth), Eigen::Vector2d(0.8 * width, 0.35 * depth),
        Eigen::Vector2d(0.75 * width, 0.8 * depth), Eigen::Vector2d(0.25 * width, 0.7 * depth)}) {
    const double x = rng.uniform(-3.0, 3.0);
    const double y = rng.uniform(-3.0, 3.0);
    builder.place(place + Eigen::Vector2d(x, y));
  }
  builder.return_to({0.5 * width, 0.5 * depth});
  builder.return_to({0.8 * width, 0.5 * depth});
  builder.return_to({4.0, 6.0});
}

void build_outdoors(World& world, Rng rng) {
  const double lot = 36.0;
  const int columns = 4;
  const int rows = 3;
  PlanBuilder builder(world, Pose2{});
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double x = (column + 0.5) * lot + rng.uniform(-3.0, 3.0);
      const double y = (row + 0.5) * lot + rng.uniform(-3.0, 3.0);
      add_house(builder, {x, y, rng.uniform(-0.3, 0.3) + (rng.below(2) == 0 ? 0.0 : 0.5 * kPi)},
                rng);
    }
  }
  // Trees and cars stand along the streets between the lots; hedges at the edge, with gaps.
  for (int line = 1; line < columns; ++line) {
    for (double y = 4.0; y < rows * lot - 4.0; y += rng.uniform(6.0, 13.0)) {
      const double x = line * lot + (rng.below(2) == 0 ? 2.6 : -2.6);
      if (rng.below(3) == 0) {
        builder.box({x, y, 0.5 * kPi + rng.uniform(-0.05, 0.05)}, 4.4, 1.8);
      } else {
        builder.circle({x, y}, rng.uniform(0.12, 0.3));
      }
    }
  }
  for (double x = 3.0; x < columns * lot - 8.0; x += rng.uniform(11.0, 22.0)) {
    for (const double y : {0.0, rows * lot}) {
      if (rng.below(3) == 0) continue;
      const double length = rng.uniform(5.0, 9.0);
      builder.box({x + 3.0, y, rng.uniform(-0.05, 0.05)}, length, 0.8);
    }
  }
  world.floor_area_m2 = columns * lot * rows * lot;
  builder.start({lot, 0.3 * lot, 0.5 * kPi});
  for (int row = 1; row < rows; ++row) {
    for (int line = 1; line < columns; ++line) builder.place({line * lot, row * lot});
  }
  builder.place({0.5 * lot, lot});
  builder.place({2.0 * lot, 2.6 * lot});
  builder.return_to({lot, 2.0 * lot});
  builder.return_to({3.0 * lot, 2.0 * lot});
  builder.return_to({3.0 * lot, lot});
  builder.return_to({lot, lot});
  builder.return_to({lot, 0.3 * lot});
}

}  // namespace loopstone
