#include "simulation/people.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {
namespace {

constexpr double kBodyRadius = 0.25;   ///< [m]
constexpr double kLegRadius = 0.06;    ///< [m]
constexpr double kHalfHip = 0.1;       ///< legs beside the middle [m]
constexpr double kHalfStride = 0.22;   ///< legs before and behind the middle [m]
constexpr double kStrideLength = 1.4;  ///< of a pair of steps [m]
constexpr double kTimeStep = 0.05;     ///< [s]
constexpr double kShy = 1.3;           ///< keeps this far from the robot's centre where it can [m]
constexpr double kTouching = 0.55;     ///< a person nearer than this has stepped out of the way [m]

}  // namespace

void add_legs_of_person(const Eigen::Vector2d& middle, const Eigen::Vector2d& forward,
                        double walked_m, std::vector<Circle>& legs) {
  const Eigen::Vector2d left(-forward.y(), forward.x());
  const double swing = kHalfStride * std::sin(2.0 * kPi * walked_m / kStrideLength);
  legs.push_back({middle + kHalfHip * left + swing * forward, kLegRadius});
  legs.push_back({middle - kHalfHip * left - swing * forward, kLegRadius});
}

Crowd::Crowd(const World& world, const Drive& drive, int count, Rng rng) : drive_(drive) {
  if (count <= 0) return;
  const FloorPlan plan = obstacles_of(world);
  const SurfaceIndex obstacles(plan);
  RoutePlanner planner(obstacles, extent_of(plan), kBodyRadius + 0.05);
  if (!planner.reach_from(world.map_T_start.translation())) return;
  const auto& cells = planner.free_cells();
  const auto any_cell = [&] {
    const std::uint32_t index = cells[rng.below(cells.size())];
    const auto columns = static_cast<std::uint32_t>(planner.frame().columns);
    return Cell{static_cast<int>(index % columns), static_cast<int>(index / columns)};
  };
  for (int i = 0; i < count; ++i) {
    Person person;
    Cell at = any_cell();
    for (int leg = 0; leg < 3; ++leg) {
      // Nobody crosses a whole campus all day: the nearest of three is where a person goes.
      const std::vector<Cell> goals{any_cell(), any_cell(), any_cell()};
      const auto way = planner.find_way(at, goals);
      if (!way) continue;
      const Path path = planner.smoothed(planner.path_of(way->cells));
      person.path.insert(person.path.end(), path.begin(), path.end());
      at = way->cells.back();
    }
    person.path_m = distances_along(person.path);
    walk(person, drive, rng);
    people_.push_back(std::move(person));
  }
}

Eigen::Vector2d Crowd::on_path(const Person& person, double at_m) {
  return point_along(person.path, person.path_m, at_m);
}

void Crowd::walk(Person& person, const Drive& drive, Rng& rng) {
  const double length = person.path_m.back();
  const double speed = rng.uniform(0.8, 1.4);
  double at = rng.uniform(0.0, length);
  double direction = rng.below(2) == 0 ? 1.0 : -1.0;
  double rest_s = 0.0;
  const auto steps = static_cast<std::size_t>(drive.duration_s() / kTimeStep) + 2;
  for (std::size_t step = 0; step < steps; ++step) {
    person.walked_m.push_back(static_cast<float>(at));
    const Eigen::Vector2d robot =
        drive.pose_at(kTimeStep * static_cast<double>(step)).translation();
    const double stride = speed * kTimeStep;
    if ((on_path(person, at) - robot).norm() < kShy) {
      const double ahead = (on_path(person, std::min(length, at + 0.4)) - robot).norm();
      const double back = (on_path(person, std::max(0.0, at - 0.4)) - robot).norm();
      direction = ahead >= back ? 1.0 : -1.0;
      rest_s = 0.0;
    }
    if (rest_s > 0.0) {
      rest_s -= kTimeStep;
      continue;
    }
    at += direction * stride;
    if (at <= 0.0 || at >= length) {
      at = std::clamp(at, 0.0, length);
      direction = -direction;
      rest_s = rng.uniform(0.0, 8.0);
    }
  }
}

std::vector<Circle> Crowd::legs_at(double time_s) const {
  std::vector<Circle> legs;
  const Eigen::Vector2d robot =
      people_.empty() ? Eigen::Vector2d(0.0, 0.0) : drive_.pose_at(time_s).translation();
  for (const Person& person : people_) {
    const double steps = std::max(0.0, time_s / kTimeStep);
    const std::size_t last = person.walked_m.size() - 1;
    const std::size_t i = std::min(static_cast<std::size_t>(steps), last);
    const double from = static_cast<double>(person.walked_m[i]);
    const double to = static_cast<double>(person.walked_m[std::min(i + 1, last)]);
    const double at = from + (to - from) * std::clamp(steps - static_cast<double>(i), 0.0, 1.0);
    const Eigen::Vector2d middle = on_path(person, at);
    if ((middle - robot).norm() < kTouching) continue;
    const Eigen::Vector2d along = on_path(person, at + 0.1) - on_path(person, at - 0.1);
    const Eigen::Vector2d forward =
        along.norm() > 0.0 ? Eigen::Vector2d(along.normalized()) : Eigen::Vector2d(1.0, 0.0);
    add_legs_of_person(middle, forward, at, legs);
  }
  return legs;
}

}  // namespace loopstone
