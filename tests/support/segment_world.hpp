#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/sensor/laser_scan.hpp"

// A place made of straight walls, and a laser in it: as small and as slow as can be, so that it can
// be trusted. Tests of the core use it where the simulator would be more than they need.
namespace loopstone::test {

struct Wall {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
};
using Walls = std::vector<Wall>;

/// The four sides of an axis-aligned rectangle.
[[nodiscard]] Walls rectangle(const Eigen::Vector2d& low, const Eigen::Vector2d& high);
/// Several places in one.
[[nodiscard]] Walls together(const std::vector<Walls>& places);
/// The same walls, moved.
[[nodiscard]] Walls moved(const Pose2& world_T_place, const Walls& place);

/// A room of 8 m x 6 m, lower left corner at the origin, with a cabinet, a pillar and a niche:
/// nothing in it is symmetric.
[[nodiscard]] Walls furnished_room();

/// Distance to the first wall along a ray; +inf when there is none. `direction` has unit length.
[[nodiscard]] double cast_ray(const Walls& walls, const Eigen::Vector2d& origin,
                              const Eigen::Vector2d& direction);
/// Distance to the nearest wall.
[[nodiscard]] double distance_to_walls(const Walls& walls, const Eigen::Vector2d& point);

/// A laser scanner without faults, unless asked for.
struct Scanner {
  double angle_min_rad = -2.356194490192345;
  double angle_increment_rad = 0.5 * 0.017453292519943295;
  std::size_t beams = 541;
  double range_max_m = 30.0;
  double time_increment_s = 0.0;
  double noise_m = 0.0;  ///< standard deviation
};

/// What the scanner sees from a pose; the robot moves on at `velocity` (its own frame) during the
/// sweep when the scanner has a time increment. `rng` is needed when there is noise.
[[nodiscard]] LaserScan scan_from(const Walls& walls, const Pose2& world_T_robot,
                                  const Pose2& robot_T_lidar, const Scanner& scanner,
                                  Rng* rng = nullptr, const Tangent2& velocity = Tangent2::Zero());

/// Poses of a robot that drives through the points: straight from one to the next in steps of
/// step_m, turning on the spot in steps of step_rad. Faces the second point at the start.
[[nodiscard]] std::vector<Pose2> drive_through(const std::vector<Eigen::Vector2d>& points,
                                               double step_m, double step_rad);

}  // namespace loopstone::test
