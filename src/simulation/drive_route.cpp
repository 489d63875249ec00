#include <algorithm>
#include <cmath>

#include "loopstone/base/error.hpp"
#include "loopstone/simulation/drive.hpp"
#include "simulation/route_planner.hpp"

namespace loopstone {
namespace {

constexpr double kMargin = 0.08;  ///< the plan keeps this much more room than the robot needs [m]
constexpr double kDriveMargin = 0.01;  ///< and the steering this much [m]
constexpr double kTurnInPlace = 0.9;   ///< off by more than this the robot stops to turn [rad]
constexpr double kCornerReach = 0.3;   ///< over which a path's turning is measured [m]

/// All legs joined; every leg's end stands in the path as planned.
Path plan_route(const World& world, RoutePlanner& planner, int laps) {
  const auto start = planner.nearest_free(world.map_T_start.translation(), 0.3);
  Cell at = *start;
  Path route{world.map_T_start.translation()};
  const auto go = [&](const std::vector<Cell>& goals) {
    const auto way = planner.find_way(at, goals);
    if (!way) return std::optional<std::size_t>{};
    planner.mark_used(way->cells);
    const Path leg = planner.smoothed(planner.path_of(way->cells));
    route.insert(route.end(), leg.begin() + (leg.size() > 1 ? 1 : 0), leg.end());
    at = way->cells.back();
    return std::optional{way->goal};
  };
  std::vector<Cell> places;
  for (const auto& place : world.places) {
    if (const auto cell = planner.nearest_free(place, 1.0)) places.push_back(*cell);
  }
  while (!places.empty()) {
    const auto reached = go(places);
    if (!reached) break;
    places.erase(places.begin() + static_cast<std::ptrdiff_t>(*reached));
  }
  std::vector<Eigen::Vector2d> returns = world.returns;
  if (returns.empty()) returns.push_back(world.map_T_start.translation());
  for (const auto& point : returns) {
    if (const auto cell = planner.nearest_free(point, 1.0)) go({*cell});
  }
  if (laps > 1) go({*start});
  const auto lap = static_cast<std::ptrdiff_t>(route.size());
  for (int i = 1; i < laps; ++i) {
    const Path again(route.begin() + 1, route.begin() + lap);
    route.insert(route.end(), again.begin(), again.end());
  }
  return route;
}

/// Arc length and speed limit at each point of a path.
struct Profile {
  std::vector<double> at_m;
  std::vector<double> limit_m_s;
};

Profile speed_profile(const Path& path, const DriveOptions& options) {
  Profile profile{distances_along(path), std::vector<double>(path.size(), options.speed_m_s)};
  constexpr std::size_t kReach = 3;  // points of about 0.1 m
  for (std::size_t i = kReach; i + kReach < path.size(); ++i) {
    const Eigen::Vector2d in = path[i] - path[i - kReach];
    const Eigen::Vector2d out = path[i + kReach] - path[i];
    const double turn = std::abs(std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out)));
    const double limit =
        turn > 1.2 ? 0.08 : 0.8 * options.yaw_rate_rad_s * kCornerReach / std::max(turn, 1e-3);
    profile.limit_m_s[i] = std::min(profile.limit_m_s[i], limit);
  }
  profile.limit_m_s.back() = 0.0;
  for (std::size_t i = path.size() - 1; i-- > 0;) {  // so that it can brake in time
    const double ahead = profile.limit_m_s[i + 1];
    const double distance = profile.at_m[i + 1] - profile.at_m[i];
    profile.limit_m_s[i] =
        std::min(profile.limit_m_s[i],
                 std::sqrt(ahead * ahead + 2.0 * 0.7 * options.acceleration_m_s2 * distance));
  }
  return profile;
}

double towards(double from, double to, double most) {
  return from + std::clamp(to - from, -most, most);
}

/// Pure pursuit; turns in place where the path turns sharply.
class Follower {
 public:
  Follower(const Path& path, const SurfaceIndex& obstacles, double radius_m,
           const DriveOptions& options)
      : path_(path),
        profile_(speed_profile(path, options)),
        obstacles_(obstacles),
        radius_m_(radius_m),
        options_(options) {}

  void run(Drive& drive) {
    const double length = profile_.at_m.back();
    // Nobody needs longer than this; whatever holds the robot up then is a mistake of this file.
    const auto most_steps = static_cast<std::size_t>((60.0 + 20.0 * length) / Drive::kStep);
    for (std::size_t step = 0; step < most_steps && !has_arrived(drive.last_pose()); ++step)
      advance(drive);
    for (int step = 0; step < 50; ++step) drive.append(0.0, 0.0);
  }

 private:
  [[nodiscard]] bool has_arrived(const Pose2& pose) const {
    return profile_.at_m.back() - profile_.at_m[nearest_] < 0.15 ||
           (nearest_ + 4 >= path_.size() && (pose.translation() - path_.back()).norm() < 0.15);
  }

  void advance(Drive& drive) {
    const Pose2& pose = drive.last_pose();
    find_nearest(pose.translation());
    const double ahead = 0.25 + 0.3 * speed_;
    const Eigen::Vector2d target =
        pose.inverse() * point_along(path_, profile_.at_m, profile_.at_m[nearest_] + ahead);
    const double distance = std::max(0.1, target.norm());
    const double off = std::atan2(target.y(), target.x());
    double speed_goal = 0.0;
    double rate_goal = std::clamp(2.0 * off, -options_.yaw_rate_rad_s, options_.yaw_rate_rad_s);
    if (std::abs(off) < kTurnInPlace) {
      const double bend = 2.0 * std::sin(off) / distance;  // Coulter 1992, section 3
      speed_goal = std::min(profile_.limit_m_s[nearest_],
                            options_.yaw_rate_rad_s / std::max(std::abs(bend), 1e-6)) *
                   std::cos(off);
      speed_goal = std::max(speed_goal, 0.05);
      rate_goal = std::clamp(std::max(speed_, 0.15) * bend, -options_.yaw_rate_rad_s,
                             options_.yaw_rate_rad_s);
    }
    const double change = options_.acceleration_m_s2 * Drive::kStep;
    speed_ = speed_goal < speed_ ? towards(speed_, speed_goal, 1.5 * change)
                                 : towards(speed_, speed_goal, change);
    rate_ = towards(rate_, rate_goal, 4.0 * Drive::kStep);
    const Eigen::Vector2d next =
        (pose * exp(Tangent2(Drive::kStep * speed_, 0.0, Drive::kStep * rate_))).translation();
    const double room = obstacles_.distance(next, radius_m_ + kDriveMargin);
    if (room < radius_m_ + kDriveMargin &&
        room <= obstacles_.distance(pose.translation(), radius_m_ + kDriveMargin)) {
      speed_ = 0.0;  // turn until the way is free
      rate_ =
          towards(rate_, std::clamp(2.0 * off, -options_.yaw_rate_rad_s, options_.yaw_rate_rad_s),
                  4.0 * Drive::kStep);
    }
    drive.append(speed_, rate_);
  }

  /// The nearest point of the path, searched a little ahead only: ways cross and come back.
  void find_nearest(const Eigen::Vector2d& position) {
    double best = (path_[nearest_] - position).squaredNorm();
    const double end = profile_.at_m[nearest_] + 0.6;
    for (std::size_t i = nearest_ + 1; i < path_.size() && profile_.at_m[i] <= end; ++i) {
      const double squared = (path_[i] - position).squaredNorm();
      if (squared <= best) {
        best = squared;
        nearest_ = i;
      }
    }
  }

  const Path& path_;
  Profile profile_;
  const SurfaceIndex& obstacles_;
  double radius_m_;
  const DriveOptions& options_;
  std::size_t nearest_ = 0;
  double speed_ = 0.0;
  double rate_ = 0.0;
};

}  // namespace

Drive drive_route(const World& world, double robot_radius_m, const DriveOptions& options) {
  const FloorPlan plan = obstacles_of(world);
  const SurfaceIndex obstacles(plan);
  RoutePlanner planner(obstacles, extent_of(plan), robot_radius_m + kMargin);
  if (!planner.reach_from(world.map_T_start.translation())) {
    throw UsageError("the start of world '" + world.name + "' has no room for a robot of radius " +
                     std::to_string(robot_radius_m) + " m");
  }
  Drive drive(world.map_T_start);
  for (double time = 0.0; time < options.standstill_s; time += Drive::kStep) drive.append(0.0, 0.0);
  const Path route = plan_route(world, planner, options.laps);
  if (route.size() > 1) Follower(route, obstacles, robot_radius_m, options).run(drive);
  return drive;
}

}  // namespace loopstone
