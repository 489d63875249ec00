#include "simulation/furniture.hpp"

#include <cmath>
#include <initializer_list>

namespace loopstone {
namespace {

constexpr int kAttempts = 12;

bool overlap(const Extent& a, const Extent& b, double gap_m) {
  return a.low.x() < b.high.x() + gap_m && b.low.x() < a.high.x() + gap_m &&
         a.low.y() < b.high.y() + gap_m && b.low.y() < a.high.y() + gap_m;
}

Extent around(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double margin_m) {
  return {a.cwiseMin(b).array() - margin_m, a.cwiseMax(b).array() + margin_m};
}

}  // namespace

void Furnisher::reserve_way(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                            double width_m) {
  const Eigen::Vector2d corner(from.x(), to.y());
  reserve(around(from, corner, 0.5 * width_m));
  reserve(around(corner, to, 0.5 * width_m));
}

bool Furnisher::claim(const Extent& area, double gap_m) {
  if ((area.low.array() < room_.low.array()).any() ||
      (area.high.array() > room_.high.array()).any()) {
    return false;
  }
  for (const Extent& other : taken_) {
    if (overlap(area, other, gap_m)) return false;
  }
  taken_.push_back(area);
  return true;
}

std::optional<Pose2> Furnisher::spot_at_wall(double length_m, double depth_m, double front_m) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const auto side = static_cast<int>(rng_.below(4));
    const double yaw = side * 0.5 * kPi;  // 0: south wall, looking north; then counter-clockwise
    const bool along_x = side % 2 == 0;
    const double room_length =
        along_x ? room_.high.x() - room_.low.x() : room_.high.y() - room_.low.y();
    const double gap = rng_.uniform(0.01, 0.06);
    const double at =
        rng_.uniform(0.5 * length_m, std::max(0.5 * length_m + 0.01, room_length - 0.5 * length_m));
    const Eigen::Vector2d corner = side == 0   ? room_.low
                                   : side == 1 ? Eigen::Vector2d(room_.high.x(), room_.low.y())
                                   : side == 2 ? room_.high
                                               : Eigen::Vector2d(room_.low.x(), room_.high.y());
    const Pose2 building_T_wall{corner.x(), corner.y(), wrap_angle(yaw)};
    const Eigen::Vector2d a = building_T_wall * Eigen::Vector2d(at - 0.5 * length_m, gap);
    const Eigen::Vector2d b =
        building_T_wall * Eigen::Vector2d(at + 0.5 * length_m, gap + depth_m + front_m);
    if (claim(around(a, b, 0.0), 0.03)) {
      return building_T_wall * Pose2{at, gap + 0.5 * depth_m, 0.0};
    }
  }
  return std::nullopt;
}

std::optional<Pose2> Furnisher::spot_inside(double length_m, double width_m, double gap_m) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const bool turned = rng_.below(2) == 1;
    const Eigen::Vector2d half(0.5 * (turned ? width_m : length_m),
                               0.5 * (turned ? length_m : width_m));
    const Eigen::Vector2d low = room_.low + half;
    const Eigen::Vector2d size = room_.high - room_.low - 2.0 * half;
    Eigen::Vector2d ratio;
    ratio.y() = rng_.uniform();
    ratio.x() = rng_.uniform();
    if ((size.array() <= 0.0).any()) continue;
    const Eigen::Vector2d centre = low + size.cwiseProduct(ratio);
    if (claim({centre - half, centre + half}, gap_m)) {
      return Pose2{centre.x(), centre.y(), turned ? 0.5 * kPi : 0.0};
    }
  }
  return std::nullopt;
}

void Furnisher::desk(const Pose2& building_T_desk) {
  const double length = 1.5;
  const double width = 0.75;
  builder_.keep_out(building_T_desk, length, width);
  const bool pedestal_left = rng_.below(2) == 0;
  const double pedestal_x = pedestal_left ? -0.5 : 0.5;
  builder_.box(building_T_desk * Pose2{pedestal_x, 0.0, 0.0}, 0.42, 0.6);
  for (const double y : {-0.32, 0.32}) {
    builder_.box(building_T_desk * Pose2{-1.4 * pedestal_x, y, 0.0}, 0.05, 0.05);
  }
  if (rng_.below(3) == 0) {  // a panel that hides the knees
    builder_.box(building_T_desk * Pose2{-0.2 * pedestal_x, -0.34, 0.0}, 1.1, 0.03);
  }
}

void Furnisher::office_chair(const Pose2& building_T_chair) {
  // At the laser's height: the back rest, the arm rests' posts.
  builder_.keep_out(building_T_chair, 0.5, 0.5);
  builder_.box(building_T_chair * Pose2{0.0, 0.2, 0.0}, 0.44, 0.06);
  for (const double x : {-0.24, 0.24})
    builder_.circle(building_T_chair * Eigen::Vector2d(x, 0.0), 0.02);
}

void Furnisher::chair(const Pose2& building_T_chair) {
  builder_.keep_out(building_T_chair, 0.42, 0.42);
  for (const double x : {-0.19, 0.19}) {
    for (const double y : {-0.19, 0.19})
      builder_.circle(building_T_chair * Eigen::Vector2d(x, y), 0.018);
  }
}

void Furnisher::desk_at_wall() {
  if (const auto spot = spot_at_wall(1.5, 0.75, 0.65)) {
    desk(*spot);
    office_chair(*spot * Pose2{rng_.uniform(-0.3, 0.3), 0.65 + rng_.uniform(-0.1, 0.05),
                               rng_.uniform(-0.5, 0.5)});
  }
}

void Furnisher::box_at_wall(double length_m, double depth_m) {
  if (const auto spot = spot_at_wall(length_m, depth_m, 0.0))
    builder_.box(*spot, length_m, depth_m);
}

void Furnisher::round_thing(double radius_m) {
  if (const auto spot = spot_at_wall(2.0 * radius_m, 2.0 * radius_m, 0.0)) {
    builder_.circle(spot->translation(), radius_m);
  }
}

void Furnisher::office(int desks) {
  for (int i = 0; i < desks; ++i) desk_at_wall();
  box_at_wall(rng_.uniform(0.8, 1.6), 0.42);
  if (rng_.below(2) == 0) box_at_wall(rng_.uniform(0.8, 1.2), 0.35);
  if (rng_.below(2) == 0) round_thing(rng_.uniform(0.12, 0.2));
  if (rng_.below(3) == 0) {
    if (const auto spot = spot_inside(0.5, 0.5, 0.3)) {
      chair(*spot * Pose2{0.0, 0.0, rng_.uniform(-kPi, kPi)});
    }
  }
}

void Furnisher::meeting_room() {
  const double length = rng_.uniform(1.8, 2.8);
  if (const auto table = spot_inside(length + 1.3, 2.3, 0.05)) {
    builder_.keep_out(*table, length, 1.1);
    for (const double x : {-0.5 * length + 0.15, 0.5 * length - 0.15}) {
      for (const double y : {-0.42, 0.42}) builder_.circle(*table * Eigen::Vector2d(x, y), 0.035);
    }
    const int seats = static_cast<int>(length / 0.75);
    for (int seat = 0; seat < seats; ++seat) {
      const double x = (seat - 0.5 * (seats - 1)) * 0.75;
      for (const double side : {-1.0, 1.0}) {
        if (rng_.below(5) == 0) continue;  // somebody took it away
        chair(*table * Pose2{x + rng_.uniform(-0.08, 0.08), side * rng_.uniform(0.7, 0.88),
                             rng_.uniform(-0.3, 0.3)});
      }
    }
  }
  box_at_wall(1.6, 0.45);
  round_thing(0.18);
}

void Furnisher::storage() {
  for (int i = 0; i < 5; ++i) {
    const double depth = rng_.uniform(0.35, 0.6);
    box_at_wall(rng_.uniform(0.9, 2.2), depth);
  }
  for (int i = 0; i < 2; ++i) {
    if (const auto spot = spot_inside(0.6, 0.4, 0.25)) {
      builder_.box(*spot * Pose2{0.0, 0.0, rng_.uniform(-0.6, 0.6)}, 0.55, 0.38);
    }
  }
}

void Furnisher::lounge() {
  for (int i = 0; i < 2; ++i) box_at_wall(rng_.uniform(1.6, 2.1), 0.8);
  for (int i = 0; i < 2; ++i) round_thing(rng_.uniform(0.16, 0.25));
  if (const auto table = spot_inside(1.1, 0.6, 0.5)) builder_.box(*table, 1.0, 0.5);
  box_at_wall(0.7, 0.65);
}

void Furnisher::open_plan() {
  // Pairs of desks face to face in rows, a screen between them, as the room has space.
  for (const double y : {room_.low.y() + 2.6, room_.high.y() - 2.6}) {
    for (double x = room_.low.x() + 1.9; x < room_.high.x() - 1.2; x += 1.62) {
      if (rng_.below(6) == 0) continue;
      if (!claim({{x - 0.8, y - 1.4}, {x + 0.8, y + 1.4}}, 0.0)) continue;
      desk({x, y + 0.4, 0.0});
      desk({x, y - 0.4, kPi});
      builder_.box({x, y, 0.0}, 1.5, 0.04);
      office_chair({x + rng_.uniform(-0.25, 0.25), y + 1.05, rng_.uniform(-0.5, 0.5)});
      office_chair({x + rng_.uniform(-0.25, 0.25), y - 1.05, kPi + rng_.uniform(-0.5, -0.1)});
    }
  }
  for (int i = 0; i < 4; ++i) box_at_wall(rng_.uniform(0.9, 1.8), 0.45);
  for (int i = 0; i < 3; ++i) round_thing(rng_.uniform(0.15, 0.22));
}

}  // namespace loopstone
