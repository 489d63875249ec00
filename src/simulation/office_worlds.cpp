#include <algorithm>
#include <array>
#include <initializer_list>

#include "simulation/builtin_worlds.hpp"
#include "simulation/office_building.hpp"

namespace loopstone {
namespace {

/// The corners of the loops that corridors and crossings form: (first, last crossing) x (south,
/// north corridor).
struct Corners {
  Eigen::Vector2d south_west, south_middle, south_east, north_west, north_middle, north_east;
};

Corners corners_of(const OfficeShape& shape) {
  const double south = shape.south_m + 0.5 * shape.corridor_m;
  const double north = south + shape.corridor_m + shape.middle_m;
  const double west = shape.crossings_m.front();
  const double middle = shape.crossings_m[shape.crossings_m.size() / 2];
  const double east = shape.crossings_m.back();
  return {{west, south}, {middle, south}, {east, south},
          {west, north}, {middle, north}, {east, north}};
}

/// Where a hall can be entered.
struct HallGates {
  Opening west, east, south;
};

/// One large room with columns and stands.
void add_hall(PlanBuilder& builder, double width, double depth, const HallGates& gates, Rng& rng) {
  const double wall = 0.3;
  const double o = 0.5 * wall;
  builder.wall({-o, -o}, {-o, depth + o}, wall, {{gates.west.at_m + o, gates.west.width_m}});
  builder.wall({width + o, -o}, {width + o, depth + o}, wall,
               {{gates.east.at_m + o, gates.east.width_m}});
  builder.wall({-o, -o}, {width + o, -o}, wall, {{gates.south.at_m + o, gates.south.width_m}});
  builder.wall({-o, depth + o}, {width + o, depth + o}, wall);
  for (double x = 6.0; x < width - 3.0; x += 8.0) {
    for (const double y : {0.28 * depth, 0.72 * depth}) builder.circle({x, y}, 0.35);
  }
  for (double x = 3.0; x < width - 4.0; x += rng.uniform(4.5, 7.5)) {  // stands and counters
    for (const double y : {0.1 * depth, 0.45 * depth, 0.9 * depth}) {
      if (rng.below(3) == 0) continue;
      const double length = rng.uniform(0.8, 3.0);
      const double thickness = rng.uniform(0.4, 1.0);
      builder.box({x + rng.uniform(-0.5, 0.5), y, rng.uniform(-0.15, 0.15)}, length, thickness);
    }
  }
  builder.world().floor_area_m2 += width * depth;
}

}  // namespace

void build_office(World& world, Rng rng) {
  OfficeShape shape;
  shape.corridor_m = rng.uniform(1.9, 2.3);
  shape.south_m = rng.uniform(4.8, 5.6);
  shape.north_m = rng.uniform(4.8, 5.6);
  shape.crossings_m = {rng.uniform(5.5, 7.5), rng.uniform(19.5, 22.5), rng.uniform(33.0, 35.0)};
  shape.open_block = 1 + static_cast<int>(rng.below(2));
  shape.visited_share = 0.6;
  PlanBuilder builder(world, Pose2{});
  add_office(builder, shape, {}, rng);
  const Corners c = corners_of(shape);
  builder.start({c.south_west.x(), c.south_west.y(), 0.0});
  for (const auto& corner :
       {c.south_middle, c.north_middle, c.north_west, c.north_east, c.south_east}) {
    builder.place(corner);
  }
  for (const auto& corner : {c.north_west, c.north_middle, c.south_middle, c.south_east,
                             c.north_east, c.north_middle, c.north_west, c.south_west}) {
    builder.return_to(corner);
  }
}

void build_campus(World& world, Rng rng) {
  // Two rows of three buildings, not quite parallel, joined to two big loops that share the middle
  // passage.
  const auto shape_of = [&](double width, double middle) {
    OfficeShape shape;
    shape.width_m = width;
    shape.middle_m = middle;
    shape.corridor_m = rng.uniform(2.0, 2.6);
    shape.south_m = rng.uniform(5.0, 6.2);
    shape.north_m = rng.uniform(5.0, 6.2);
    shape.crossings_m = {width * rng.uniform(0.12, 0.2), width * rng.uniform(0.46, 0.54),
                         width * rng.uniform(0.82, 0.88)};
    shape.open_block = 1 + static_cast<int>(rng.below(2));
    shape.visited_share = 0.08;
    return shape;
  };
  const OfficeShape sw = shape_of(58.0, 13.0);
  const OfficeShape s = shape_of(52.0, 12.0);
  const OfficeShape se = shape_of(56.0, 13.0);
  const OfficeShape nw = shape_of(60.0, 12.0);
  const OfficeShape ne = shape_of(54.0, 13.0);
  PlanBuilder in_sw(world, Pose2{});
  PlanBuilder in_s(world, Pose2{84.0, -3.0, radians(rng.uniform(3.0, 7.0))});
  PlanBuilder in_se(world, Pose2{164.0, 2.0, radians(rng.uniform(-6.0, -2.0))});
  PlanBuilder in_nw(world, Pose2{-2.0, 66.0, radians(rng.uniform(-5.0, -1.0))});
  PlanBuilder in_hall(world, Pose2{86.0, 66.0, 0.0});
  PlanBuilder in_ne(world, Pose2{160.0, 64.0, radians(rng.uniform(2.0, 6.0))});

  const OfficeExits sw_exits = add_office(in_sw, sw, {.east_north = true, .north = true}, rng);
  const OfficeExits s_exits =
      add_office(in_s, s, {.west_south = true, .east_north = true, .north = true}, rng);
  const OfficeExits se_exits = add_office(in_se, se, {.west_south = true, .north = true}, rng);
  const OfficeExits nw_exits = add_office(in_nw, nw, {.east_south = true, .south = true}, rng);
  const OfficeExits ne_exits = add_office(in_ne, ne, {.west_north = true, .south = true}, rng);

  const double hall_width = 50.0;
  const double hall_depth = 26.0;
  const Opening west_gate{9.0, 2.4};
  const Opening east_gate{17.0, 2.4};
  const Opening south_gate{24.0, 2.4};
  add_hall(in_hall, hall_width, hall_depth, {west_gate, east_gate, south_gate}, rng);
  const auto hall_gate = [&](const Eigen::Vector2d& left, const Eigen::Vector2d& right) {
    return Gate{in_hall.in_map(left), in_hall.in_map(right)};
  };
  const Gate hall_west = hall_gate({-0.3, west_gate.at_m - 1.2}, {-0.3, west_gate.at_m + 1.2});
  const Gate hall_east =
      hall_gate({hall_width + 0.3, east_gate.at_m + 1.2}, {hall_width + 0.3, east_gate.at_m - 1.2});
  const Gate hall_south = hall_gate({south_gate.at_m + 1.2, -0.3}, {south_gate.at_m - 1.2, -0.3});

  add_passage(world, sw_exits.east_north, s_exits.west_south, rng);
  add_passage(world, s_exits.east_north, se_exits.west_south, rng);
  add_passage(world, sw_exits.north, nw_exits.south, rng);
  add_passage(world, se_exits.north, ne_exits.south, rng);
  add_passage(world, nw_exits.east_south, hall_west, rng);
  add_passage(world, hall_east, ne_exits.west_north, rng);
  add_passage(world, s_exits.north, hall_south, rng);

  const Corners c_sw = corners_of(sw);
  const Corners c_s = corners_of(s);
  const Corners c_se = corners_of(se);
  const Corners c_nw = corners_of(nw);
  const Corners c_ne = corners_of(ne);
  in_sw.start({c_sw.south_west.x(), c_sw.south_west.y(), 0.0});
  for (const auto& [builder, c] :
       {std::pair{&in_sw, &c_sw}, std::pair{&in_s, &c_s}, std::pair{&in_se, &c_se},
        std::pair{&in_nw, &c_nw}, std::pair{&in_ne, &c_ne}}) {
    for (const auto& corner : {c->south_middle, c->north_east}) builder->place(corner);
  }
  in_hall.place({8.0, 0.6 * hall_depth});
  in_hall.place({38.0, 0.3 * hall_depth});
  // The visit ends in the southern middle. Close the outer ring, then go round the western loop the
  // other way.
  in_s.return_to(c_s.south_middle);
  in_sw.return_to(c_sw.north_east);
  in_nw.return_to(c_nw.south_middle);
  in_hall.return_to({24.0, 0.6 * hall_depth});
  in_s.return_to(c_s.north_middle);
  in_s.return_to(c_s.south_west);
  in_sw.return_to(c_sw.south_west);
}

}  // namespace loopstone
