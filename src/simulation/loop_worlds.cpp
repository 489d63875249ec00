// Worlds whose difficulty is where one is: long ways round, and places that look alike.

#include "simulation/builtin_worlds.hpp"
#include "simulation/plan_builder.hpp"

namespace loopstone {
namespace {

constexpr double kOuterWall = 0.3;
constexpr double kWall = 0.14;

/// What breaks a bare corridor: door frames, a pilaster, rarely a thing that stands there. The
/// wall's face is its x axis, the corridor to the left of it.
void furnish_wall(PlanBuilder& builder, const Pose2& building_T_wall, double length, Rng& rng) {
  for (double x = rng.uniform(2.0, 9.0); x < length - 2.0; x += rng.uniform(5.0, 14.0)) {
    const auto kind = rng.below(6);
    const double size = rng.uniform(0.25, 0.6);
    if (kind < 3) {  // both sides of a door's frame
      for (const double side : {-0.55, 0.55})
        builder.box(building_T_wall * Pose2{x + side, 0.03, 0.0}, 0.1, 0.08);
    } else if (kind < 5) {
      builder.box(building_T_wall * Pose2{x, 0.06, 0.0}, size, 0.14);
    } else {
      builder.box(building_T_wall * Pose2{x, 0.2, 0.0}, 2.0 * size, 0.38);
    }
  }
}

/// One room of a wing, the same everywhere; its door is in its southern wall.
void fill_alike(PlanBuilder& builder, const Pose2& building_T_room, double room) {
  for (const double x : {-0.6, 0.6}) {
    for (const double y : {-0.35, 0.35})
      builder.circle(building_T_room * Eigen::Vector2d(0.35 * room + x, 0.7 * room + y), 0.035);
  }
  builder.keep_out(building_T_room * Pose2{0.35 * room, 0.7 * room, 0.0}, 1.3, 0.8);
  builder.box(building_T_room * Pose2{room - 0.32, 0.5 * room, 0.0}, 0.45, 1.2);
}

struct WingShape {
  double corridor_m = 2.2;
  double room_m = 4.6;
  int rooms = 4;  ///< on each side

  [[nodiscard]] double length_m() const { return rooms * room_m; }
  [[nodiscard]] double width_m() const { return 2.0 * room_m + corridor_m; }
};

/// A wing: rooms on both sides of a corridor along x, its mouth at x = 0.
void add_wing(PlanBuilder& builder, const Pose2& building_T_wing, const WingShape& shape) {
  const double half = 0.5 * shape.corridor_m;
  const double outer = half + shape.room_m;
  const double length = shape.length_m();
  const auto at = [&](double x, double y) { return building_T_wing * Eigen::Vector2d(x, y); };
  std::vector<Opening> left_doors;
  std::vector<Opening> right_doors;
  for (int i = 0; i < shape.rooms; ++i) {
    const double x = i * shape.room_m;
    fill_alike(builder, building_T_wing * Pose2{x, half, 0.0}, shape.room_m);
    fill_alike(builder, building_T_wing * Pose2{x + shape.room_m, -half, kPi}, shape.room_m);
    left_doors.push_back({x + 0.62 * shape.room_m, 1.05});
    right_doors.push_back({x + 0.38 * shape.room_m, 1.05});
    if (i == 0) continue;
    builder.wall(at(x, half), at(x, outer), kWall);
    builder.wall(at(x, -half), at(x, -outer), kWall);
  }
  builder.wall(at(0.0, half), at(length, half), kWall, left_doors);
  builder.wall(at(0.0, -half), at(length, -half), kWall, right_doors);
  builder.wall(at(0.0, outer), at(length, outer), kOuterWall);
  builder.wall(at(0.0, -outer), at(length, -outer), kOuterWall);
  builder.wall(at(length, -outer), at(length, outer), kOuterWall);
  builder.place(at(length - 1.2, 0.0));
  builder.place(at(2.55 * shape.room_m, half + 0.4 * shape.room_m));
}

constexpr int kWings = 4;

/// A spine along x with wings to its north; open to the west, where the stairs are.
void add_floor(PlanBuilder& builder, const Pose2& building_T_floor, const WingShape& wing,
               double spine_m) {
  const double width = kWings * wing.width_m();
  const auto at = [&](double x, double y) { return building_T_floor * Eigen::Vector2d(x, y); };
  std::vector<Opening> mouths;
  for (int i = 0; i < kWings; ++i) {
    const double x = (i + 0.5) * wing.width_m();
    mouths.push_back({x, wing.corridor_m - kWall});
    add_wing(builder, building_T_floor * Pose2{x, spine_m, 0.5 * kPi}, wing);
  }
  builder.wall(at(0.0, spine_m), at(width, spine_m), kWall, mouths);
  builder.wall(at(0.0, 0.0), at(width, 0.0), kOuterWall);
  builder.wall(at(width, 0.0), at(width, spine_m), kOuterWall);
  builder.world().floor_area_m2 += width * (spine_m + wing.length_m());
}

}  // namespace

void build_loops(World& world, Rng rng) {
  const double round = rng.uniform(100.0, 400.0);  // along the corridors' middles
  const double corridor = rng.uniform(2.1, 2.6);
  const double length = round * rng.uniform(0.28, 0.36);
  const double depth = 0.5 * round - length;
  PlanBuilder builder(world, Pose2{});
  const double width = length + corridor;
  const double height = depth + corridor;
  builder.shell(width, height, kOuterWall);
  const double far_x = width - corridor;
  const double far_y = height - corridor;
  const double w = corridor + 0.5 * kWall;  // the block's walls stand outside the corridors
  builder.wall({w, w}, {width - w, w}, kWall);
  builder.wall({w, height - w}, {width - w, height - w}, kWall);
  builder.wall({w, w}, {w, height - w}, kWall);
  builder.wall({width - w, w}, {width - w, height - w}, kWall);
  world.floor_area_m2 -= (far_x - corridor) * (far_y - corridor);
  // The outer walls' faces, then the block's.
  furnish_wall(builder, {0.0, 0.0, 0.0}, width, rng);
  furnish_wall(builder, {width, 0.0, 0.5 * kPi}, height, rng);
  furnish_wall(builder, {width, height, kPi}, width, rng);
  furnish_wall(builder, {0.0, height, -0.5 * kPi}, height, rng);
  furnish_wall(builder, {far_x, corridor, kPi}, far_x - corridor, rng);
  furnish_wall(builder, {far_x, far_y, -0.5 * kPi}, far_y - corridor, rng);
  furnish_wall(builder, {corridor, far_y, 0.0}, far_x - corridor, rng);
  furnish_wall(builder, {corridor, corridor, 0.5 * kPi}, far_y - corridor, rng);
  const double m = 0.5 * corridor;
  builder.start({0.5 * width, m, 0.0});
  for (const auto& corner :
       {Eigen::Vector2d(width - m, m), Eigen::Vector2d(width - m, height - m),
        Eigen::Vector2d(m, height - m), Eigen::Vector2d(m, m), Eigen::Vector2d(0.5 * width, m),
        Eigen::Vector2d(0.5 * width + 10.0, m)}) {
    builder.return_to(corner);
  }
}

void build_wings(World& world, Rng rng) {
  WingShape wing;
  wing.corridor_m = rng.uniform(2.0, 2.4);
  wing.room_m = rng.uniform(4.4, 5.0);
  wing.rooms = 3 + static_cast<int>(rng.below(2));
  const double spine = rng.uniform(2.2, 2.6);
  const double stairs = rng.uniform(2.2, 2.6);
  const double upper = spine + wing.length_m() + rng.uniform(6.0, 12.0);
  PlanBuilder builder(world, Pose2{});
  add_floor(builder, {0.0, 0.0, 0.0}, wing, spine);
  add_floor(builder, {0.0, upper, 0.0}, wing, spine);
  // The passage to the west of both.
  builder.wall({-stairs, 0.0}, {-stairs, upper + spine}, kOuterWall);
  builder.wall({-stairs, 0.0}, {0.0, 0.0}, kOuterWall);
  builder.wall({-stairs, upper + spine}, {0.0, upper + spine}, kOuterWall);
  builder.wall({0.0, spine}, {0.0, upper}, kOuterWall);
  world.floor_area_m2 += stairs * (upper + spine);
  const double m = 0.5 * spine;
  const double east = kWings * wing.width_m();
  builder.start({1.0, m, 0.0});
  builder.place({east - 1.5, m});
  builder.return_to({east - 1.5, upper + m});
  builder.return_to({-0.5 * stairs, upper + m});
  builder.return_to({1.0, m});
  builder.return_to({2.5 * wing.width_m(), m});
}

}  // namespace loopstone
