#include "simulation/standers.hpp"

#include <algorithm>
#include <cmath>

#include "simulation/people.hpp"

namespace loopstone {
namespace {

constexpr double kClear = 0.6;     ///< from the robot's way [m]
constexpr double kBody = 0.2;      ///< and from walls [m]
constexpr double kFarthest = 1.8;  ///< from the way [m]
constexpr double kSway = 0.03;     ///< [m]
constexpr int kTries = 100;        ///< for each of them

bool is_off_the_way(const std::vector<Eigen::Vector2d>& way, const Eigen::Vector2d& point) {
  return std::ranges::none_of(
      way, [&](const Eigen::Vector2d& at) { return (at - point).squaredNorm() < kClear * kClear; });
}

}  // namespace

Standers::Standers(const Drive& drive, const SurfaceIndex& surfaces, const RealismStanders& options,
                   Rng rng) {
  std::vector<Eigen::Vector2d> way;
  for (double time = 0.0; time <= drive.duration_s(); time += 0.3)
    way.push_back(drive.pose_at(time).translation());
  for (int person = 0; person < options.count; ++person) {
    for (int attempt = 0; attempt < kTries; ++attempt) {
      const double met_s = rng.uniform(0.0, drive.duration_s());
      const Pose2 robot = drive.pose_at(met_s);
      const double aside = rng.uniform(kClear, kFarthest) * (rng.below(2) == 0 ? 1.0 : -1.0);
      const double yaw = rng.uniform(-kPi, kPi);
      const Eigen::Vector2d at = robot * Eigen::Vector2d(0.0, aside);
      const Eigen::Vector2d direction = (at - robot.translation()).normalized();
      const double wall = surfaces.cast(robot.translation(), direction, 2.0 * kFarthest);
      if (wall < std::abs(aside) + kBody || surfaces.distance(at, kBody) < kBody ||
          !is_off_the_way(way, at)) {
        continue;
      }
      const double before = rng.uniform(20.0, 150.0);
      const double after = rng.uniform(20.0, 150.0);
      people_.push_back(
          {{at.x(), at.y(), yaw}, met_s - before, met_s + after, rng.uniform(0.0, 2.0 * kPi)});
      break;
    }
  }
}

void Standers::add_legs(double time_s, std::vector<Circle>& legs) const {
  for (const Stander& person : people_) {
    if (time_s < person.from_s || time_s >= person.to_s) continue;
    const double sway = kSway * std::sin(0.9 * time_s + person.phase_rad);
    add_legs_of_person(person.map_T_person * Eigen::Vector2d(0.0, sway),
                       {std::cos(person.map_T_person.yaw), std::sin(person.map_T_person.yaw)}, 0.0,
                       legs);
  }
}

}  // namespace loopstone
