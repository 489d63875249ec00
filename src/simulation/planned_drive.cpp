#include "simulation/planned_drive.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "simulation/route_planner.hpp"

namespace loopstone {
namespace {

constexpr double kMargin = 0.1;      ///< room beside the robot where it is set down [m]
constexpr double kSeenWithin = 1.0;  ///< a place that the robot came so near to is seen [m]
constexpr int kTries = 200;          ///< at one distance
constexpr double kLostRoom = 0.5;    ///< a robot that stands nearer to things than it plans to [m]
constexpr double kDetour = 1.3;      ///< who carries a robot walks no longer way than so many times
constexpr double kRest = 1.0;        ///< before it goes on [s]

/// Around what stands between the two, as somebody walks who carries a robot; nothing where that is
/// no way of about this length.
/// \param start, goal  the free cells nearest to them
std::optional<Path> way_between(RoutePlanner& planner, Cell start, Cell goal,
                                const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  const auto way = planner.find_way(start, {goal});
  if (!way) return std::nullopt;
  Path path = planner.smoothed(planner.path_of(way->cells));
  path.front() = from;
  path.back() = to;
  if (distances_along(path).back() > kDetour * (to - from).norm()) return std::nullopt;
  return path;
}

/// The way to where there is room for the robot at about that distance from where it is; nearer
/// when there is none.
/// \param is_blind  nobody sees which way it took: any place will do
std::optional<Path> way_to_set_down(const World& world, double robot_radius_m,
                                    const Eigen::Vector2d& from, double distance_m, bool is_blind,
                                    Rng& rng) {
  const FloorPlan plan = obstacles_of(world);
  const SurfaceIndex obstacles(plan);
  RoutePlanner planner(obstacles, extent_of(plan), robot_radius_m + kMargin);
  if (!planner.reach_from(world.map_T_start.translation())) return std::nullopt;
  const auto start = planner.nearest_free(from, kLostRoom);
  for (double distance = distance_m; distance > 0.2; distance *= 0.8) {
    for (int attempt = 0; attempt < kTries; ++attempt) {
      const double bearing = rng.uniform(0.0, 2.0 * kPi);
      const Eigen::Vector2d at =
          from + distance * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
      const auto goal = planner.nearest_free(at, 0.1);
      if (!goal) continue;
      if (is_blind) return Path{from, at};
      if (!start) return std::nullopt;
      if (auto way = way_between(planner, *start, *goal, from, at)) return way;
    }
  }
  return std::nullopt;
}

World rest_of(World world, const Drive& driven) {
  const auto is_seen = [&](const Eigen::Vector2d& place) {
    for (double time = 0.0; time < driven.duration_s(); time += 0.5) {
      if ((driven.pose_at(time).translation() - place).norm() < kSeenWithin) return true;
    }
    return false;
  };
  std::erase_if(world.places, is_seen);
  if (world.returns.empty()) world.returns.push_back(world.map_T_start.translation());
  world.map_T_start = driven.last_pose();
  return world;
}

Drive carried_away(Drive drive, const World& world, double robot_radius_m,
                   const DriveOptions& options, const RealismCarried& carried, bool is_blind,
                   Rng rng) {
  if (carried.at_s >= drive.duration_s()) return drive;
  Drive driven = drive;
  driven.cut(carried.at_s);
  const Pose2 from = driven.last_pose();
  const double turn = rng.below(2) == 0 ? carried.turn_rad : -carried.turn_rad;
  const auto way =
      way_to_set_down(world, robot_radius_m, from.translation(), carried.distance_m, is_blind, rng);
  if (!way) return drive;
  driven.carry_along(*way, wrap_angle(from.yaw + turn), carried.lift_s, is_blind);
  DriveOptions rest = options;
  rest.standstill_s = kRest;
  driven.append(drive_route(rest_of(world, driven), robot_radius_m, rest));
  return driven;
}

}  // namespace

Drive planned_drive(const World& world, double robot_radius_m, const DriveOptions& options,
                    const Realism& realism, std::uint64_t seed) {
  DriveOptions start = options;
  if (realism.rolling.on) start.standstill_s = 0.0;
  Drive drive = drive_route(world, robot_radius_m, start);
  if (realism.rolling.on) {
    drive = drive.without_first(std::min(realism.rolling.skipped_s, 0.5 * drive.duration_s()));
  }
  struct Lift {
    const RealismCarried& carried;
    bool is_blind;
    const char* name;
  };
  std::array lifts{Lift{realism.carried, false, "carried"},
                   Lift{realism.carried_blind, true, "carried_blind"}};
  const bool is_blind_first = realism.carried_blind.at_s < realism.carried.at_s;
  for (std::size_t i = 0; i < lifts.size(); ++i) {
    const Lift& lift = lifts[is_blind_first ? lifts.size() - 1 - i : i];
    if (!lift.carried.on) continue;
    drive = carried_away(std::move(drive), world, robot_radius_m, options, lift.carried,
                         lift.is_blind, realism_stream(seed, lift.name));
  }
  return drive;
}

}  // namespace loopstone
