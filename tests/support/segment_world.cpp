#include "support/segment_world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "loopstone/geometry/angle.hpp"

namespace loopstone::test {

Walls rectangle(const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  const Eigen::Vector2d right(high.x(), low.y());
  const Eigen::Vector2d left(low.x(), high.y());
  return {{low, right}, {right, high}, {high, left}, {left, low}};
}

Walls together(const std::vector<Walls>& places) {
  Walls all;
  for (const auto& place : places) all.insert(all.end(), place.begin(), place.end());
  return all;
}

Walls moved(const Pose2& world_T_place, const Walls& place) {
  Walls result;
  for (const auto& wall : place) {
    result.push_back({world_T_place * wall.from, world_T_place * wall.to});
  }
  return result;
}

Walls furnished_room() {
  return together({
      {{{0.0, 0.0}, {8.0, 0.0}},
       {{8.0, 0.0}, {8.0, 6.0}},
       // the upper wall has a niche, 0.5 m deep
       {{8.0, 6.0}, {5.0, 6.0}},
       {{5.0, 6.0}, {5.0, 6.5}},
       {{5.0, 6.5}, {4.2, 6.5}},
       {{4.2, 6.5}, {4.2, 6.0}},
       {{4.2, 6.0}, {0.0, 6.0}},
       {{0.0, 6.0}, {0.0, 0.0}}},
      rectangle({6.8, 0.0}, {7.4, 1.7}),                                // a cabinet
      moved({2.0, 4.6, 0.5}, rectangle({-0.25, -0.25}, {0.25, 0.25})),  // a pillar
  });
}

double cast_ray(const Walls& walls, const Eigen::Vector2d& origin,
                const Eigen::Vector2d& direction) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& wall : walls) {
    // origin + range * direction == from + share * along
    const Eigen::Vector2d along = wall.to - wall.from;
    const double cross = direction.x() * along.y() - direction.y() * along.x();
    if (cross == 0.0) continue;
    const Eigen::Vector2d offset = wall.from - origin;
    const double range = (offset.x() * along.y() - offset.y() * along.x()) / cross;
    const double share = (offset.x() * direction.y() - offset.y() * direction.x()) / cross;
    if (range > 0.0 && share >= 0.0 && share <= 1.0) nearest = std::min(nearest, range);
  }
  return nearest;
}

double distance_to_walls(const Walls& walls, const Eigen::Vector2d& point) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& wall : walls) {
    const Eigen::Vector2d along = wall.to - wall.from;
    const double share = std::clamp((point - wall.from).dot(along) / along.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (point - wall.from - share * along).norm());
  }
  return nearest;
}

LaserScan scan_from(const Walls& walls, const Pose2& world_T_robot, const Pose2& robot_T_lidar,
                    const Scanner& scanner, Rng* rng, const Tangent2& velocity) {
  LaserScan scan{.angle_min_rad = scanner.angle_min_rad,
                 .angle_increment_rad = scanner.angle_increment_rad,
                 .range_min_m = 0.05,
                 .range_max_m = scanner.range_max_m,
                 .time_increment_s = scanner.time_increment_s};
  for (std::size_t beam = 0; beam < scanner.beams; ++beam) {
    const double elapsed_s = static_cast<double>(beam) * scanner.time_increment_s;
    const Pose2 world_T_lidar = world_T_robot * exp(velocity * elapsed_s) * robot_T_lidar;
    const double angle = world_T_lidar.yaw + scan.angle_rad(beam);
    double range = cast_ray(walls, world_T_lidar.translation(), {std::cos(angle), std::sin(angle)});
    if (scanner.noise_m > 0.0) range += rng->normal(0.0, scanner.noise_m);
    if (range > scanner.range_max_m) range = std::numeric_limits<double>::infinity();
    scan.ranges_m.push_back(static_cast<float>(range));
  }
  return scan;
}

std::vector<Pose2> drive_through(const std::vector<Eigen::Vector2d>& points, double step_m,
                                 double step_rad) {
  std::vector<Pose2> poses;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Eigen::Vector2d along = points[i + 1] - points[i];
    const double heading = std::atan2(along.y(), along.x());
    const double before = poses.empty() ? heading : poses.back().yaw;
    const double turn = wrap_angle(heading - before);
    const int turns = static_cast<int>(std::ceil(std::abs(turn) / step_rad));
    for (int k = 1; k < turns; ++k) {
      poses.push_back({points[i].x(), points[i].y(), wrap_angle(before + turn * k / turns)});
    }
    const int steps = std::max(1, static_cast<int>(std::ceil(along.norm() / step_m)));
    for (int k = i == 0 || turns > 0 ? 0 : 1; k <= steps; ++k) {
      const Eigen::Vector2d at = points[i] + along * k / steps;
      poses.push_back({at.x(), at.y(), heading});
    }
  }
  return poses;
}

}  // namespace loopstone::test
