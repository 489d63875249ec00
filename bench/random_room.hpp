#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/simulation/floor_plan.hpp"
#include "simulation/plan_builder.hpp"

namespace loopstone::bench {

/// A furnished room of several metres and what can be seen of the corridor around it through its
/// doors.
struct RandomRoom {
  World world{};
  Extent inside{};  ///< between the room's four walls
};

namespace detail {

inline constexpr double kWallThickness = 0.15;

/// A recess behind an opening in a wall: its back and its two sides.
inline void add_niche(PlanBuilder& builder, const Pose2& room_T_niche, double width_m,
                      double depth_m) {
  const double t = kWallThickness;
  builder.box(room_T_niche * Pose2{0.0, -depth_m - 0.5 * t, 0.0}, width_m + 2.0 * t, t);
  for (const double side : {-1.0, 1.0}) {
    builder.box(room_T_niche * Pose2{side * 0.5 * (width_m + t), -0.5 * depth_m, 0.0}, t,
                depth_m + t);
  }
}

/// One wall, built along x with the room at y > 0: a door, niches and pilasters come in different
/// places.
inline void add_wall(PlanBuilder& builder, Rng& rng, const Pose2& room_T_wall, double length_m,
                     bool with_door) {
  const double slot_m = 1.6;  // at most one thing in each slot, so that they don't overlap
  const int slots = static_cast<int>(length_m / slot_m);
  const int door = with_door ? static_cast<int>(rng.below(static_cast<std::uint64_t>(slots))) : -1;
  std::vector<Opening> openings;
  for (int slot = 0; slot < slots; ++slot) {
    const double at = (length_m - slots * slot_m) / 2.0 + (slot + 0.5) * slot_m;
    if (slot == door) {
      openings.push_back({at, 0.95});
      if (rng.uniform() < 0.5) {  // its leaf, ajar, into the room
        const double ajar = rng.uniform(0.3, 1.6);
        const Pose2 wall_T_hinge{at - 0.475, 0.05, ajar};
        builder.box(room_T_wall * wall_T_hinge * Pose2{0.45, 0.0, 0.0}, 0.9, 0.04);
      }
    } else if (rng.uniform() < 0.2) {
      const double width = rng.uniform(0.5, 1.3);
      openings.push_back({at, width});
      add_niche(builder, room_T_wall * Pose2{at, 0.0, 0.0}, width, rng.uniform(0.15, 0.5));
    } else if (rng.uniform() < 0.2) {
      const double depth = rng.uniform(0.1, 0.3);
      builder.box(room_T_wall * Pose2{at + rng.uniform(-0.4, 0.4), 0.5 * depth, 0.0},
                  rng.uniform(0.2, 0.5), depth);
    } else if (rng.uniform() < 0.35) {  // a cabinet
      const double depth = rng.uniform(0.3, 0.6);
      builder.box(room_T_wall * Pose2{at, 0.5 * (kWallThickness + depth), 0.0},
                  rng.uniform(0.6, 1.5), depth);
    }
  }
  builder.wall(room_T_wall * Eigen::Vector2d(0.0, 0.0),
               room_T_wall * Eigen::Vector2d(length_m, 0.0), kWallThickness, openings);
}

/// What stands about in the room: pillars, tables and chairs (their legs), crates at any angle.
inline void add_things(PlanBuilder& builder, Rng& rng, const Extent& inside) {
  const auto anywhere = [&](double margin) {
    return Pose2{rng.uniform(inside.low.x() + margin, inside.high.x() - margin),
                 rng.uniform(inside.low.y() + margin, inside.high.y() - margin),
                 rng.uniform(-kPi, kPi)};
  };
  const int pillars = static_cast<int>(rng.below(3));
  for (int i = 0; i < pillars; ++i) {
    const Pose2 at = anywhere(0.8);
    if (rng.uniform() < 0.5) {
      builder.circle(at.translation(), rng.uniform(0.1, 0.25));
    } else {
      const double side = rng.uniform(0.25, 0.5);
      builder.box({at.x, at.y, 0.0}, side, side);
    }
  }
  const int tables = static_cast<int>(rng.below(4));
  for (int i = 0; i < tables; ++i) {
    const Pose2 room_T_table = anywhere(0.7);
    const double half_length = rng.uniform(0.2, 0.7);
    const double half_width = rng.uniform(0.2, 0.4);
    for (const double x : {-half_length, half_length}) {
      for (const double y : {-half_width, half_width}) {
        builder.circle(room_T_table * Eigen::Vector2d(x, y), 0.025);
      }
    }
  }
  const int crates = static_cast<int>(rng.below(3));
  for (int i = 0; i < crates; ++i) {
    builder.box(anywhere(0.5), rng.uniform(0.3, 0.9), rng.uniform(0.3, 0.6));
  }
}

}  // namespace detail

/// No two numbers of `rng` give the same room: other size, doors, niches, pilasters, cabinets,
/// pillars, tables, crates, and in some a corner that is cut off or a partition.
[[nodiscard]] inline RandomRoom make_random_room(Rng rng) {
  RandomRoom room;
  PlanBuilder builder(room.world, Pose2{});
  const double width = rng.uniform(4.5, 11.0);
  const double depth = rng.uniform(4.0, 8.0);
  room.inside = {{0.0, 0.0}, {width, depth}};
  // Counter-clockwise, the room to the left of every wall.
  const std::array<Pose2, 4> walls{Pose2{0.0, 0.0, 0.0}, Pose2{width, 0.0, 0.5 * kPi},
                                   Pose2{width, depth, kPi}, Pose2{0.0, depth, -0.5 * kPi}};
  const std::uint64_t first_door = rng.below(4);
  const bool second_door = rng.uniform() < 0.4;
  for (std::uint64_t i = 0; i < walls.size(); ++i) {
    const bool door = i == first_door || (second_door && i == (first_door + 2) % 4);
    detail::add_wall(builder, rng, walls[i], i % 2 == 0 ? width : depth, door);
  }
  if (rng.uniform() < 0.35) {  // the corner is cut off: an L-shaped room
    const double along_x = rng.uniform(0.8, 0.4 * width);
    const double along_y = rng.uniform(0.8, 0.4 * depth);
    const double x = rng.uniform() < 0.5 ? 0.5 * along_x : width - 0.5 * along_x;
    const double y = rng.uniform() < 0.5 ? 0.5 * along_y : depth - 0.5 * along_y;
    builder.box({x, y, 0.0}, along_x, along_y);
  }
  if (rng.uniform() < 0.3) {  // a partition, from a wall towards the middle
    const double x = rng.uniform(0.3, 0.7) * width;
    const double length = rng.uniform(0.25, 0.5) * depth;
    const double y = rng.uniform() < 0.5 ? 0.5 * length : depth - 0.5 * length;
    builder.box({x, y, 0.5 * kPi}, length, 0.1);
  }
  detail::add_things(builder, rng, room.inside);
  // The other side of the corridors around the room.
  const double corridor = rng.uniform(1.4, 2.6);
  const Eigen::Vector2d low(-corridor, -corridor);
  const Eigen::Vector2d high(width + corridor, depth + corridor);
  for (const auto& [a, b] : {std::pair{low, Eigen::Vector2d(high.x(), low.y())},
                             std::pair{Eigen::Vector2d(high.x(), low.y()), high},
                             std::pair{high, Eigen::Vector2d(low.x(), high.y())},
                             std::pair{Eigen::Vector2d(low.x(), high.y()), low}}) {
    builder.wall(a, b, detail::kWallThickness);
  }
  return room;
}

}  // namespace loopstone::bench
