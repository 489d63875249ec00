#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/simulation/surface_index.hpp"
#include "loopstone/simulation/world.hpp"

namespace loopstone::test {

/// A wall from corner to corner of a rectangle.
inline Box block(double low_x, double low_y, double high_x, double high_y) {
  return {{0.5 * (low_x + high_x), 0.5 * (low_y + high_y), 0.0}, high_x - low_x, high_y - low_y};
}

/// Four walls 0.2 m thick around the inside of a room.
inline void add_room(FloorPlan& plan, double low_x, double low_y, double high_x, double high_y) {
  plan.boxes.push_back(block(low_x - 0.2, low_y - 0.2, high_x + 0.2, low_y));
  plan.boxes.push_back(block(low_x - 0.2, high_y, high_x + 0.2, high_y + 0.2));
  plan.boxes.push_back(block(low_x - 0.2, low_y, low_x, high_y));
  plan.boxes.push_back(block(high_x, low_y, high_x + 0.2, high_y));
}

/// A room of 9.3 by 6.1 m with a cabinet, a slanted partition and a column: it looks different from
/// everywhere.
inline World room_with_cabinet() {
  World world;
  add_room(world.plan, 0.03, 0.01, 9.33, 6.11);
  world.plan.boxes.push_back(block(0.03, 4.5, 1.6, 6.11));
  world.plan.boxes.push_back({{6.0, 2.0, 0.5}, 2.2, 0.15});
  world.plan.circles.push_back({{3.4, 1.7}, 0.22});
  world.map_T_start = {4.5, 4.0, 0.0};
  return world;
}

/// Ranges with 1 cm noise, 0.5 deg apart over 270 deg, as points in the laser's frame.
inline std::vector<Eigen::Vector2d> scan_at(const SurfaceIndex& surfaces, const Pose2& map_T_laser,
                                            Rng& rng) {
  std::vector<Eigen::Vector2d> points;
  for (int beam = 0; beam <= 540; ++beam) {
    const double angle = radians(-135.0 + 0.5 * beam);
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    const double range =
        surfaces.cast(map_T_laser.translation(), map_T_laser.rotation() * direction, 30.0);
    const double noise = rng.normal(0.0, 0.01);
    if (std::isfinite(range)) points.push_back((range + noise) * direction);
  }
  return points;
}

/// Somewhere between the corners, outside of everything and 0.3 m from it.
inline Pose2 place_in(const World& world, const SurfaceIndex& surfaces, const Eigen::Vector2d& low,
                      const Eigen::Vector2d& high, Rng& rng) {
  while (true) {
    const Eigen::Vector2d at(rng.uniform(low.x(), high.x()), rng.uniform(low.y(), high.y()));
    if (surfaces.distance(at, 1.0) < 0.3) continue;
    if (std::any_of(world.plan.boxes.begin(), world.plan.boxes.end(),
                    [&](const Box& box) { return is_inside(box, at); })) {
      continue;
    }
    return {at.x(), at.y(), rng.uniform(-kPi, kPi)};
  }
}

}  // namespace loopstone::test
