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

OfficeShape campus_shape(double width, double middle, Rng& rng) {
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
}

constexpr double kCampusHallWidth = 50.0;
constexpr double kCampusHallDepth = 26.0;

struct HallExits {
  Gate west, east, south;
};

HallExits add_campus_hall(PlanBuilder& builder, Rng& rng) {
  const HallGates gates{.west = {9.0, 2.4}, .east = {17.0, 2.4}, .south = {24.0, 2.4}};
  add_hall(builder, kCampusHallWidth, kCampusHallDepth, gates, rng);
  const auto gate = [&](const Eigen::Vector2d& left, const Eigen::Vector2d& right) {
    return Gate{builder.in_map(left), builder.in_map(right)};
  };
  const double east = kCampusHallWidth + 0.3;
  return {.west = gate({-0.3, gates.west.at_m - 1.2}, {-0.3, gates.west.at_m + 1.2}),
          .east = gate({east, gates.east.at_m + 1.2}, {east, gates.east.at_m - 1.2}),
          .south = gate({gates.south.at_m + 1.2, -0.3}, {gates.south.at_m - 1.2, -0.3})};
}

/// Its buildings by where they stand.
struct Campus {
  struct Office {
    PlanBuilder builder;
    Corners corners;
  };
  Office sw, s, se, nw;
  PlanBuilder hall;
  Office ne;
};

/// What a robot is to see of it, and how it comes back.
void plan_visit(Campus& campus) {
  const Eigen::Vector2d& start = campus.sw.corners.south_west;
  campus.sw.builder.start({start.x(), start.y(), 0.0});
  for (Campus::Office* office : {&campus.sw, &campus.s, &campus.se, &campus.nw, &campus.ne}) {
    for (const auto& corner : {office->corners.south_middle, office->corners.north_east})
      office->builder.place(corner);
  }
  campus.hall.place({8.0, 0.6 * kCampusHallDepth});
  campus.hall.place({38.0, 0.3 * kCampusHallDepth});
  // The visit ends in the southern middle. Close the outer ring, then go round the western loop the
  // other way.
  campus.s.builder.return_to(campus.s.corners.south_middle);
  campus.sw.builder.return_to(campus.sw.corners.north_east);
  campus.nw.builder.return_to(campus.nw.corners.south_middle);
  campus.hall.return_to({24.0, 0.6 * kCampusHallDepth});
  campus.s.builder.return_to(campus.s.corners.north_middle);
  campus.s.builder.return_to(campus.s.corners.south_west);
  campus.sw.builder.return_to(campus.sw.corners.south_west);
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
  const OfficeShape sw = campus_shape(58.0, 13.0, rng);
  const OfficeShape s = campus_shape(52.0, 12.0, rng);
  const OfficeShape se = campus_shape(56.0, 13.0, rng);
  const OfficeShape nw = campus_shape(60.0, 12.0, rng);
  const OfficeShape ne = campus_shape(54.0, 13.0, rng);
  Campus campus{
      .sw = {PlanBuilder(world, Pose2{}), corners_of(sw)},
      .s = {PlanBuilder(world, Pose2{84.0, -3.0, radians(rng.uniform(3.0, 7.0))}), corners_of(s)},
      .se = {PlanBuilder(world, Pose2{164.0, 2.0, radians(rng.uniform(-6.0, -2.0))}),
             corners_of(se)},
      .nw = {PlanBuilder(world, Pose2{-2.0, 66.0, radians(rng.uniform(-5.0, -1.0))}),
             corners_of(nw)},
      .hall = PlanBuilder(world, Pose2{86.0, 66.0, 0.0}),
      .ne = {PlanBuilder(world, Pose2{160.0, 64.0, radians(rng.uniform(2.0, 6.0))}),
             corners_of(ne)}};

  const OfficeExits sw_exits =
      add_office(campus.sw.builder, sw, {.east_north = true, .north = true}, rng);
  const OfficeExits s_exits =
      add_office(campus.s.builder, s, {.west_south = true, .east_north = true, .north = true}, rng);
  const OfficeExits se_exits =
      add_office(campus.se.builder, se, {.west_south = true, .north = true}, rng);
  const OfficeExits nw_exits =
      add_office(campus.nw.builder, nw, {.east_south = true, .south = true}, rng);
  const OfficeExits ne_exits =
      add_office(campus.ne.builder, ne, {.west_north = true, .south = true}, rng);
  const HallExits hall_exits = add_campus_hall(campus.hall, rng);

  add_passage(world, sw_exits.east_north, s_exits.west_south, rng);
  add_passage(world, s_exits.east_north, se_exits.west_south, rng);
  add_passage(world, sw_exits.north, nw_exits.south, rng);
  add_passage(world, se_exits.north, ne_exits.south, rng);
  add_passage(world, nw_exits.east_south, hall_exits.west, rng);
  add_passage(world, hall_exits.east, ne_exits.west_north, rng);
  add_passage(world, s_exits.north, hall_exits.south, rng);
  plan_visit(campus);
}

}  // namespace loopstone
