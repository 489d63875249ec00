#include "simulation/office_building.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "simulation/furniture.hpp"

namespace loopstone {
namespace {

constexpr double kWall = 0.12;
constexpr double kOuterWall = 0.3;

/// Along x.
struct Stretch {
  double from = 0.0;
  double to = 0.0;
};

enum class DoorSide { kSouth, kNorth };

/// Cuts a stretch into rooms of uneven width.
std::vector<Stretch> rooms_of(const Stretch& stretch, Rng& rng) {
  std::vector<Stretch> rooms;
  double at = stretch.from;
  while (stretch.to - at > 8.2) {
    const double width = rng.uniform(3.1, 6.4);
    rooms.push_back({at, at + width});
    at += width;
  }
  if (stretch.to - at > 6.4) {
    const double half = 0.5 * (at + stretch.to);
    rooms.push_back({at, half});
    at = half;
  }
  rooms.push_back({at, stretch.to});
  return rooms;
}

/// The parts of [0, width] between the gaps.
std::vector<Stretch> between(double width, const std::vector<Opening>& gaps) {
  std::vector<Stretch> stretches;
  double from = 0.0;
  for (const Opening& gap : gaps) {
    stretches.push_back({from, gap.at_m - 0.5 * gap.width_m});
    from = gap.at_m + 0.5 * gap.width_m;
  }
  stretches.push_back({from, width});
  return stretches;
}

/// An open door leaf in the room, hinged at one jamb.
void add_door_leaf(PlanBuilder& builder, double jamb_x, double y, bool hinge_on_left, DoorSide side,
                   double width, Rng& rng) {
  const double into = side == DoorSide::kSouth ? 1.0 : -1.0;
  const double lean = rng.uniform(0.0, 0.25) * (hinge_on_left ? 1.0 : -1.0);
  const double direction = std::atan2(into, 0.0) + lean * into;
  const Pose2 hinge{jamb_x, y, direction};
  builder.box(hinge * Pose2{0.5 * width + 0.06, 0.0, 0.0}, width, 0.04);
}

/// One room: its furniture, its place, its door. Returns the door as an opening along x.
Opening add_room(PlanBuilder& builder, const Extent& room, DoorSide side, double visited_share,
                 Rng& rng) {
  const double width = rng.uniform(0.95, 1.08);
  const double margin = 0.5 * width + 0.25;
  const double door_x = rng.uniform(room.low.x() + margin, room.high.x() - margin);
  const double door_y = side == DoorSide::kSouth ? room.low.y() : room.high.y();
  const double into = side == DoorSide::kSouth ? 1.0 : -1.0;
  const Eigen::Vector2d size = room.high - room.low;
  const Eigen::Vector2d centre = 0.5 * (room.low + room.high);
  Eigen::Vector2d place = centre;
  place.y() += rng.uniform(-0.1, 0.1) * size.y();
  place.x() += rng.uniform(-0.12, 0.12) * size.x();
  const Eigen::Vector2d door(door_x, door_y + into * 0.5);

  if (rng.below(3) != 0) {
    const bool left = rng.below(2) == 0;
    const double jamb = door_x + (left ? -0.5 : 0.5) * (width + 0.04);
    add_door_leaf(builder, jamb, door_y, left, side, width - 0.08, rng);
  }
  Furnisher furnisher(builder, rng,
                      {room.low.array() + 0.5 * kWall, room.high.array() - 0.5 * kWall});
  furnisher.reserve({{door_x - 0.75, door_y - 1.25}, {door_x + 0.75, door_y + 1.25}});
  furnisher.reserve_way(door, place, 1.0);
  furnisher.reserve({place.array() - 0.6, place.array() + 0.6});
  const double area = size.x() * size.y();
  switch (rng.below(7)) {
    case 0:
      furnisher.storage();
      break;
    case 1:
      furnisher.lounge();
      break;
    case 2:
      furnisher.meeting_room();
      break;
    default:
      furnisher.office(std::max(1, static_cast<int>(area / 9.0)));
  }
  if (rng.uniform() < visited_share) builder.place(place);
  return {door_x, width};
}

/// A row of rooms between y = low and high; returns their doors.
std::vector<Opening> add_room_row(PlanBuilder& builder, const std::vector<Stretch>& stretches,
                                  double low, double high, DoorSide side, double visited_share,
                                  Rng& rng) {
  std::vector<Opening> doors;
  for (const Stretch& stretch : stretches) {
    const std::vector<Stretch> rooms = rooms_of(stretch, rng);
    for (std::size_t i = 0; i < rooms.size(); ++i) {
      doors.push_back(
          add_room(builder, {{rooms[i].from, low}, {rooms[i].to, high}}, side, visited_share, rng));
      if (i + 1 < rooms.size()) builder.wall({rooms[i].to, low}, {rooms[i].to, high}, kWall);
    }
  }
  return doors;
}

void add_open_plan(PlanBuilder& builder, const Extent& room, std::vector<Opening>& south_doors,
                   std::vector<Opening>& north_doors, Rng& rng) {
  Furnisher furnisher(builder, rng,
                      {room.low.array() + 0.5 * kWall, room.high.array() - 0.5 * kWall});
  const Eigen::Vector2d centre = 0.5 * (room.low + room.high);
  const double south_x = rng.uniform(room.low.x() + 1.0, centre.x() - 0.8);
  const double north_x = rng.uniform(centre.x() + 0.8, room.high.x() - 1.0);
  south_doors.push_back({south_x, 1.5});
  north_doors.push_back({north_x, 1.5});
  furnisher.reserve_way({south_x, room.low.y()}, centre, 1.5);
  furnisher.reserve_way({north_x, room.high.y()}, centre, 1.5);
  for (const double x : {0.3, 0.7}) {
    for (const double y : {-1.1, 1.1}) {  // what holds the roof, beside the aisle in the middle
      const Eigen::Vector2d column(room.low.x() + x * (room.high.x() - room.low.x()),
                                   centre.y() + y);
      builder.circle(column, 0.22);
      furnisher.reserve({column.array() - 0.3, column.array() + 0.3});
    }
  }
  furnisher.open_plan();
  builder.place(centre);
}

/// Pilasters, cabinets, plants, copiers along the walls of a corridor.
void decorate_corridor(PlanBuilder& builder, double width, double low, double high,
                       const std::vector<Opening>& low_openings,
                       const std::vector<Opening>& high_openings, Rng& rng) {
  const auto is_clear = [](const std::vector<Opening>& openings, double x, double half) {
    return std::none_of(openings.begin(), openings.end(), [&](const Opening& o) {
      return std::abs(o.at_m - x) < 0.5 * o.width_m + half + 0.45;
    });
  };
  for (double x = rng.uniform(1.0, 4.0); x < width - 1.0; x += rng.uniform(2.5, 6.0)) {
    const bool on_low_wall = rng.below(2) == 0;
    const double length = rng.uniform(0.35, 1.2);
    if (!is_clear(on_low_wall ? low_openings : high_openings, x, 0.5 * length)) continue;
    const double face = on_low_wall ? low + 0.5 * kWall : high - 0.5 * kWall;
    const double into = on_low_wall ? 1.0 : -1.0;
    switch (rng.below(4)) {
      case 0:
        builder.circle({x, face + into * 0.22}, 0.17);
        break;
      case 1:
        builder.box({x, face + into * 0.2, 0.0}, length, 0.38);
        break;
      default:
        builder.box({x, face + into * 0.06, 0.0}, 0.4, 0.14);
    }
  }
}

/// Where things stand along y, from the south, and the crossings along x.
struct OfficeLines {
  double width = 0.0;
  double y1 = 0.0;  ///< southern rooms end, their corridor begins
  double y2 = 0.0;
  double y3 = 0.0;  ///< blocks end, the northern corridor begins
  double y4 = 0.0;
  double y5 = 0.0;  ///< northern rooms end
  std::vector<Opening> crossings{};

  [[nodiscard]] const Opening& middle() const { return crossings[crossings.size() / 2]; }
  /// Of the gates at the ends of the corridors.
  [[nodiscard]] double south_end() const { return 0.5 * (y1 + y2); }
  [[nodiscard]] double north_end() const { return 0.5 * (y3 + y4); }
};

OfficeLines lines_of(const OfficeShape& shape) {
  OfficeLines lines;
  lines.width = shape.width_m;
  lines.y1 = shape.south_m;
  lines.y2 = lines.y1 + shape.corridor_m;
  lines.y3 = lines.y2 + shape.middle_m;
  lines.y4 = lines.y3 + shape.corridor_m;
  lines.y5 = lines.y4 + shape.north_m;
  for (const double x : shape.crossings_m) lines.crossings.push_back({x, shape.crossing_m});
  return lines;
}

/// Blocks of rooms between the corridors; adds their doors to the openings of the walls.
void add_blocks(PlanBuilder& builder, const OfficeShape& shape, const OfficeLines& lines,
                std::vector<Opening>& south_openings, std::vector<Opening>& north_openings,
                Rng& rng) {
  const double low = lines.y2;
  const double high = lines.y3;
  const double half = 0.5 * (low + high);
  const std::vector<Stretch> blocks = between(lines.width, lines.crossings);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Stretch& block = blocks[i];
    if (static_cast<int>(i) == shape.open_block) {
      add_open_plan(builder, {{block.from, low}, {block.to, high}}, south_openings, north_openings,
                    rng);
    } else {
      for (const Opening& door :
           add_room_row(builder, {block}, low, half, DoorSide::kSouth, shape.visited_share, rng)) {
        south_openings.push_back(door);
      }
      for (const Opening& door :
           add_room_row(builder, {block}, half, high, DoorSide::kNorth, shape.visited_share, rng)) {
        north_openings.push_back(door);
      }
      builder.wall({block.from, half}, {block.to, half}, kWall);
    }
    if (i > 0) builder.wall({block.from, low}, {block.from, high}, kWall);
    if (i + 1 < blocks.size()) builder.wall({block.to, low}, {block.to, high}, kWall);
  }
}

/// Both walls of a crossing that goes on through a row of rooms.
void add_way_out(PlanBuilder& builder, const Opening& crossing, double low, double high) {
  for (const double side : {-0.5, 0.5}) {
    const double x = crossing.at_m + side * crossing.width_m;
    builder.wall({x, low}, {x, high}, kWall);
  }
}

double gate_width(const OfficeShape& shape) { return shape.corridor_m - kWall; }
double crossing_gate_width(const OfficeShape& shape) { return shape.crossing_m - kWall; }

/// It stands outside the nominal rectangle.
void add_outer_wall(PlanBuilder& builder, const OfficeShape& shape, const OfficeLines& lines,
                    const OfficeGates& gates) {
  const double o = 0.5 * kOuterWall;
  const auto ends = [&](bool south, bool north) {
    std::vector<Opening> openings;
    if (south) openings.push_back({lines.south_end() + o, gate_width(shape)});
    if (north) openings.push_back({lines.north_end() + o, gate_width(shape)});
    return openings;
  };
  const auto side = [&](bool is_open) {
    return is_open ? std::vector<Opening>{{lines.middle().at_m + o, crossing_gate_width(shape)}}
                   : std::vector<Opening>{};
  };
  const double east = lines.width + o;
  const double north = lines.y5 + o;
  builder.wall({-o, -o}, {-o, north}, kOuterWall, ends(gates.west_south, gates.west_north));
  builder.wall({east, -o}, {east, north}, kOuterWall, ends(gates.east_south, gates.east_north));
  builder.wall({-o, -o}, {east, -o}, kOuterWall, side(gates.south));
  builder.wall({-o, north}, {east, north}, kOuterWall, side(gates.north));
}

OfficeExits exits_of(const PlanBuilder& builder, const OfficeShape& shape,
                     const OfficeLines& lines) {
  const auto at = [&](double x, double y) { return builder.in_map({x, y}); };
  const double g = 0.5 * gate_width(shape);
  const double c = 0.5 * crossing_gate_width(shape);
  const double out = kOuterWall;
  const double south_end = lines.south_end();
  const double north_end = lines.north_end();
  const double middle = lines.middle().at_m;
  return {{at(-out, south_end - g), at(-out, south_end + g)},
          {at(lines.width + out, south_end + g), at(lines.width + out, south_end - g)},
          {at(-out, north_end - g), at(-out, north_end + g)},
          {at(lines.width + out, north_end + g), at(lines.width + out, north_end - g)},
          {at(middle + c, -out), at(middle - c, -out)},
          {at(middle - c, lines.y5 + out), at(middle + c, lines.y5 + out)}};
}

}  // namespace

double depth_of(const OfficeShape& shape) {
  return shape.south_m + 2.0 * shape.corridor_m + shape.middle_m + shape.north_m;
}

OfficeExits add_office(PlanBuilder& builder, const OfficeShape& shape, const OfficeGates& gates,
                       Rng& rng) {
  const OfficeLines lines = lines_of(shape);
  const auto through = [&](bool is_open) {
    return is_open ? std::vector{lines.middle()} : std::vector<Opening>{};
  };
  const std::vector<Opening> through_south = through(gates.south);
  const std::vector<Opening> through_north = through(gates.north);
  // The openings in the walls of the corridors, from the south.
  std::vector<Opening> openings_1 =
      add_room_row(builder, between(lines.width, through_south), 0.0, lines.y1, DoorSide::kNorth,
                   shape.visited_share, rng);
  std::vector<Opening> openings_4 =
      add_room_row(builder, between(lines.width, through_north), lines.y4, lines.y5,
                   DoorSide::kSouth, shape.visited_share, rng);
  openings_1.insert(openings_1.end(), through_south.begin(), through_south.end());
  openings_4.insert(openings_4.end(), through_north.begin(), through_north.end());
  std::vector<Opening> openings_2 = lines.crossings;
  std::vector<Opening> openings_3 = lines.crossings;
  add_blocks(builder, shape, lines, openings_2, openings_3, rng);

  builder.wall({0.0, lines.y1}, {lines.width, lines.y1}, kWall, openings_1);
  builder.wall({0.0, lines.y2}, {lines.width, lines.y2}, kWall, openings_2);
  builder.wall({0.0, lines.y3}, {lines.width, lines.y3}, kWall, openings_3);
  builder.wall({0.0, lines.y4}, {lines.width, lines.y4}, kWall, openings_4);
  decorate_corridor(builder, lines.width, lines.y1, lines.y2, openings_1, openings_2, rng);
  decorate_corridor(builder, lines.width, lines.y3, lines.y4, openings_3, openings_4, rng);
  if (gates.south) add_way_out(builder, lines.middle(), 0.0, lines.y1);
  if (gates.north) add_way_out(builder, lines.middle(), lines.y4, lines.y5);
  add_outer_wall(builder, shape, lines, gates);
  builder.world().floor_area_m2 += lines.width * lines.y5;
  return exits_of(builder, shape, lines);
}

void add_passage(World& world, const Gate& from, const Gate& to, Rng& rng) {
  PlanBuilder builder(world, Pose2{});
  const double thickness = 0.2;
  const auto side = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b, double outward) {
    const Eigen::Vector2d along = (b - a).normalized();
    const Eigen::Vector2d left(-along.y(), along.x());
    const Eigen::Vector2d shift = outward * 0.5 * thickness * left;
    builder.wall(a + shift, b + shift, thickness);
    const double yaw = std::atan2(along.y(), along.x());
    for (double s = rng.uniform(1.5, 4.0); s < (b - a).norm() - 1.0; s += rng.uniform(3.0, 7.0)) {
      const Eigen::Vector2d foot = a + s * along - outward * 0.06 * left;
      builder.box({foot.x(), foot.y(), yaw}, rng.uniform(0.2, 0.5), 0.16);
    }
  };
  side(from.left, to.right, 1.0);
  side(from.right, to.left, -1.0);
  const double width = 0.5 * ((from.left - from.right).norm() + (to.left - to.right).norm());
  const double length = (0.5 * (from.left + from.right) - 0.5 * (to.left + to.right)).norm();
  world.floor_area_m2 += width * length;
}

}  // namespace loopstone
