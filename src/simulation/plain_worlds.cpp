#include "simulation/builtin_worlds.hpp"
#include "simulation/furniture.hpp"
#include "simulation/office_building.hpp"

namespace loopstone {
namespace {

constexpr double kOuterWall = 0.3;

/// Two back-to-back rows of bays along x: posts at the corners of the bays, pallets between them.
void add_rack(PlanBuilder& builder, const Eigen::Vector2d& low, int bays, double bay_m,
              double depth_m, Rng& rng) {
  const double length = bays * bay_m;
  builder.keep_out({low.x() + 0.5 * length, low.y() + depth_m, 0.0}, length, 2.0 * depth_m);
  for (int post = 0; post <= bays; ++post) {
    for (const double y : {0.06, depth_m - 0.06, depth_m + 0.06, 2.0 * depth_m - 0.06}) {
      builder.box({low.x() + post * bay_m, low.y() + y, 0.0}, 0.1, 0.1);
    }
  }
  for (int bay = 0; bay < bays; ++bay) {
    for (int row = 0; row < 2; ++row) {
      for (int slot = 0; slot < 3; ++slot) {
        if (rng.below(4) == 0) continue;  // empty
        const double x =
            low.x() + bay * bay_m + (slot + 0.5) * bay_m / 3.0 + rng.uniform(-0.04, 0.04);
        const double y = low.y() + (row + 0.5) * depth_m + rng.uniform(-0.06, 0.06);
        const double width = rng.uniform(0.75, 0.95);
        builder.box({x, y, rng.uniform(-0.05, 0.05)}, 0.75, width);
      }
    }
  }
}

}  // namespace

void build_corridor(World& world, Rng rng) {
  const double length = 100.0;
  const double width = rng.uniform(2.2, 2.6);
  const double room = 7.0;
  const double low = 0.5 * (room - width);
  const double high = low + width;
  const double end = room + length;
  PlanBuilder builder(world, Pose2{});
  const double o = 0.5 * kOuterWall;
  for (const double x : {0.0, end}) {
    const bool is_west = x == 0.0;
    builder.wall({x - o, -o}, {x + room + o, -o}, kOuterWall);
    builder.wall({x - o, room + o}, {x + room + o, room + o}, kOuterWall);
    builder.wall({x - o, -o}, {x - o, room + o}, kOuterWall,
                 is_west ? std::vector<Opening>{} : std::vector<Opening>{{0.5 * room + o, width}});
    builder.wall({x + room + o, -o}, {x + room + o, room + o}, kOuterWall,
                 is_west ? std::vector<Opening>{{0.5 * room + o, width}} : std::vector<Opening>{});
    Furnisher furnisher(builder, rng, {{x, 0.0}, {x + room, room}});
    furnisher.reserve({{x, low}, {x + room, high}});
    if (is_west) {
      furnisher.lounge();
    } else {
      furnisher.storage();
    }
  }
  builder.wall({room, low - o}, {end, low - o}, kOuterWall);
  builder.wall({room, high + o}, {end, high + o}, kOuterWall);
  world.floor_area_m2 = 2.0 * room * room + length * width;
  const double middle = 0.5 * room;
  builder.start({2.0, middle, 0.0});
  builder.place({end + 0.6 * room, middle});
  builder.return_to({2.0, middle});
  builder.return_to({room + 0.5 * length, middle});
  builder.return_to({2.0, middle});
}

void build_rooms(World& world, Rng rng) {
  const int columns = 8;
  const double room = 5.0;
  const double corridor = 2.2;
  const double side = 2.2;  // the passages at both ends that close the ring
  const double wall = 0.14;
  const double width = columns * room + 2.0 * side;
  const double depth = 4.0 * room + 2.0 * corridor;
  PlanBuilder builder(world, Pose2{});
  builder.shell(width, depth, kOuterWall);
  // One room's contents, drawn once and repeated.
  const double table_x = rng.uniform(0.3, 0.4) * room;
  const double table_y = rng.uniform(0.66, 0.74) * room;
  const double cabinet_y = rng.uniform(0.4, 0.6) * room;
  const double door_x = rng.uniform(0.6, 0.72) * room;
  const auto fill = [&](const Pose2& building_T_room) {
    for (const double x : {-0.7, 0.7}) {
      for (const double y : {-0.35, 0.35}) {
        builder.circle(building_T_room * Eigen::Vector2d(table_x + x, table_y + y), 0.035);
      }
    }
    builder.keep_out(building_T_room * Pose2{table_x, table_y, 0.0}, 1.5, 0.8);
    builder.box(building_T_room * Pose2{room - 0.5 * wall - 0.24, cabinet_y, 0.0}, 0.45, 1.2);
    builder.place(building_T_room * Eigen::Vector2d(0.55 * room, 0.42 * room));
  };
  // Rows 0 and 1 face each other over the southern corridor, rows 2 and 3 over the northern one.
  const double y_of_row[] = {0.0, room + corridor, 2.0 * room + corridor,
                             3.0 * room + 2.0 * corridor};
  for (int row = 0; row < 4; ++row) {
    const bool door_is_north = row % 2 == 0;
    std::vector<Opening> doors;
    for (int column = 0; column < columns; ++column) {
      const double x = side + column * room;
      if (door_is_north) {
        fill({x + room, y_of_row[row] + room, kPi});
        doors.push_back({(column + 1) * room - door_x, 1.05});
      } else {
        fill({x, y_of_row[row], 0.0});
        doors.push_back({column * room + door_x, 1.05});
      }
      builder.wall({x, y_of_row[row]}, {x, y_of_row[row] + room}, wall);
    }
    const double east = side + columns * room;
    builder.wall({east, y_of_row[row]}, {east, y_of_row[row] + room}, wall);
    const double door_wall = y_of_row[row] + (door_is_north ? room : 0.0);
    builder.wall({side, door_wall}, {east, door_wall}, wall, doors);
  }
  const double middle = 2.0 * room + corridor;
  builder.wall({side, middle}, {side + columns * room, middle}, wall);
  const double south = room + 0.5 * corridor;
  const double north = 3.0 * room + 1.5 * corridor;
  builder.start({0.5 * side, south, 0.0});
  for (const auto& corner :
       {Eigen::Vector2d(width - 0.5 * side, south), Eigen::Vector2d(width - 0.5 * side, north),
        Eigen::Vector2d(0.5 * side, north)}) {
    builder.place(corner);
  }
  builder.return_to({0.5 * side, north});
  builder.return_to({width - 0.5 * side, north});
  builder.return_to({width - 0.5 * side, south});
  builder.return_to({0.5 * side, south});
}

void build_warehouse(World& world, Rng rng) {
  const double width = 62.0;
  const double depth = 34.0;
  const double bay = 2.7;
  const double rack_depth = 1.1;
  const double aisle = rng.uniform(2.6, 3.0);
  const int bays = 8;
  PlanBuilder builder(world, Pose2{});
  builder.shell(width, depth, kOuterWall);
  const double first_x = 6.0;
  const double second_x = first_x + bays * bay + 3.4;
  const double dock_x = second_x + bays * bay + 1.5;
  double y = 3.0;
  for (; y + 2.0 * rack_depth + 2.6 < depth; y += 2.0 * rack_depth + aisle) {
    add_rack(builder, {first_x, y}, bays, bay, rack_depth, rng);
    add_rack(builder, {second_x, y}, bays, bay, rack_depth, rng);
    builder.place({first_x + 0.5 * bays * bay, y - 0.5 * aisle});
    builder.place({second_x + 0.5 * bays * bay, y - 0.5 * aisle});
  }
  for (double x = 10.0; x < width; x += 12.0) {  // pillars along the walls
    for (const double wall_y : {0.2, depth - 0.2}) builder.box({x, wall_y, 0.0}, 0.4, 0.4);
  }
  // The office in the corner by the dock, and pallets that wait there.
  builder.wall({width - 5.0, 0.0}, {width - 5.0, 6.0}, 0.14, {{4.2, 1.05}});
  builder.wall({width - 5.0, 6.0}, {width, 6.0}, 0.14);
  Furnisher office(builder, rng, {{width - 4.9, 0.05}, {width, 5.9}});
  office.reserve_way({width - 4.9, 4.2}, {width - 2.5, 3.0}, 1.2);
  office.office(2);
  builder.place({width - 3.0, 3.6});
  for (double pallet_y = 9.0; pallet_y < depth - 3.0; pallet_y += rng.uniform(2.0, 4.5)) {
    builder.box({rng.uniform(dock_x + 5.2, width - 1.2), pallet_y, rng.uniform(-0.4, 0.4)}, 1.2,
                0.8);
  }
  const double cross = second_x - 1.7;
  builder.start({3.0, 1.5, 0.0});
  builder.place({dock_x + 1.5, 0.5 * depth});
  builder.return_to({cross, depth - 2.0});
  builder.return_to({cross, 1.5});
  builder.return_to({dock_x + 1.0, 0.7 * depth});
  builder.return_to({3.0, 1.5});
}

}  // namespace loopstone
