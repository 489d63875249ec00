#include "simulation/company.hpp"

#include <algorithm>
#include <cmath>

#include "simulation/people.hpp"

namespace loopstone {
namespace {

constexpr double kTimeStep = 0.05;   ///< between breadcrumbs [s]
constexpr double kLeastWay = 0.002;  ///< less than this is turning in place [m]
constexpr double kSway = 0.12;       ///< to both sides of the way [m]
constexpr double kSwayLength = 6.0;  ///< of way [m]
constexpr double kNearest = 0.45;    ///< nobody's middle comes nearer to the robot's [m]
constexpr double kBeforeWall = 0.2;  ///< nor to a wall [m]

bool is_within(double time_s, double from_s, double to_s) {
  return time_s >= from_s && (to_s <= 0.0 || time_s < to_s);
}

double end_of(double to_s, double duration_s) {
  return to_s <= 0.0 ? duration_s : std::min(to_s, duration_s);
}

}  // namespace

Breadcrumbs::Breadcrumbs(const Drive& drive) {
  const auto count = static_cast<std::size_t>(drive.duration_s() / kTimeStep) + 2;
  for (std::size_t i = 0; i < count; ++i) {
    const Pose2 pose = drive.pose_at(kTimeStep * static_cast<double>(i));
    const double step =
        poses_.empty() ? 0.0 : (pose.translation() - poses_.back().translation()).norm();
    ways_m_.push_back(poses_.empty() ? 0.0 : ways_m_.back() + (step > kLeastWay ? step : 0.0));
    poses_.push_back(pose);
  }
}

double Breadcrumbs::way_m(double time_s) const {
  const double steps = std::max(0.0, time_s / kTimeStep);
  const std::size_t i = std::min(static_cast<std::size_t>(steps), ways_m_.size() - 1);
  const std::size_t next = std::min(i + 1, ways_m_.size() - 1);
  return ways_m_[i] + (ways_m_[next] - ways_m_[i]) * (steps - std::floor(steps));
}

Pose2 Breadcrumbs::at_way(double way_m) const {
  if (way_m <= 0.0) return poses_.front() * Pose2{way_m, 0.0, 0.0};
  if (way_m >= ways_m_.back()) return poses_.back() * Pose2{way_m - ways_m_.back(), 0.0, 0.0};
  const auto after = std::upper_bound(ways_m_.begin(), ways_m_.end(), way_m);
  const auto i = static_cast<std::size_t>(after - ways_m_.begin());
  const double ratio = (way_m - ways_m_[i - 1]) / (ways_m_[i] - ways_m_[i - 1]);
  return interpolate(poses_[i - 1], poses_[i], ratio);
}

Company::Company(const Drive& drive, const SurfaceIndex& surfaces, const Realism& realism,
                 std::uint64_t seed)
    : drive_(drive),
      surfaces_(surfaces),
      crumbs_(drive),
      follower_(realism.follower),
      ahead_(realism.ahead),
      crowd_(realism.crowd) {
  follower_phase_rad_ = realism_stream(seed, "follower").uniform(0.0, 2.0 * kPi);
  ahead_phase_rad_ = realism_stream(seed, "ahead").uniform(0.0, 2.0 * kPi);
  Rng rng = realism_stream(seed, "crowd");
  for (int i = 0; i < crowd_.count; ++i) {
    const double slot = 2.0 * kPi / crowd_.count;
    Bystander one;
    one.bearing_rad = slot * (i + rng.uniform(-0.3, 0.3));
    one.distance = rng.uniform(0.75, 1.25);
    one.phase_rad = rng.uniform(0.0, 2.0 * kPi);
    ring_.push_back(one);
  }
}

void Company::add_person(const Pose2& robot, Eigen::Vector2d at, double yaw_rad, double walked_m,
                         double body_m, std::vector<Circle>& legs) const {
  const Eigen::Vector2d away = at - robot.translation();
  const double distance = away.norm();
  if (distance < kNearest) {
    const Eigen::Vector2d aside = distance > 1e-3
                                      ? Eigen::Vector2d(away / distance)
                                      : Eigen::Vector2d(-std::sin(robot.yaw), std::cos(robot.yaw));
    at = robot.translation() + kNearest * aside;
  }
  if (body_m > 0.0) {
    legs.push_back({at, body_m});
  } else {
    add_legs_of_person(at, {std::cos(yaw_rad), std::sin(yaw_rad)}, walked_m, legs);
  }
}

void Company::add_walker(const Pose2& robot, double way_m, double aside_m, double phase_rad,
                         double body_m, std::vector<Circle>& legs) const {
  const Pose2 on_way = crumbs_.at_way(way_m);
  double aside = aside_m + kSway * std::sin(2.0 * kPi * way_m / kSwayLength + phase_rad);
  const double side = aside < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector2d left(-std::sin(on_way.yaw), std::cos(on_way.yaw));
  const double wall = surfaces_.cast(on_way.translation(), side * left, std::abs(aside) + 1.0);
  aside = side * std::min(std::abs(aside), std::max(0.0, wall - kBeforeWall));
  const Pose2 person = on_way * Pose2{0.0, aside, 0.0};
  add_person(robot, person.translation(), person.yaw, way_m, body_m, legs);
}

void Company::add_ring(double time_s, const Pose2& robot, std::vector<Circle>& legs) const {
  const double walked = crumbs_.way_m(time_s);
  for (const Bystander& one : ring_) {
    const double bearing = one.bearing_rad + 0.25 * std::sin(0.3 * time_s + one.phase_rad);
    const Eigen::Vector2d direction(std::cos(bearing), std::sin(bearing));
    double distance =
        crowd_.radius_m * one.distance + 0.1 * std::sin(0.7 * time_s + 2.0 * one.phase_rad);
    const double wall = surfaces_.cast(robot.translation(), direction, 2.0 * distance + 1.0);
    distance = std::min(distance, wall - kBeforeWall);
    if (distance < kNearest) continue;  // no room there
    add_person(robot, robot.translation() + distance * direction, robot.yaw, walked + one.phase_rad,
               crowd_.body_m, legs);
  }
}

void Company::add_legs(double time_s, std::vector<Circle>& legs) const {
  const Pose2 robot = drive_.pose_at(time_s);
  const double way = crumbs_.way_m(time_s);
  if (follower_.on && is_within(time_s, follower_.from_s, follower_.to_s)) {
    add_walker(robot, way - follower_.gap_m, follower_.aside_m, follower_phase_rad_,
               follower_.body_m, legs);
  }
  if (ahead_.on && is_within(time_s, ahead_.from_s, ahead_.to_s))
    add_walker(robot, way + ahead_.gap_m, 0.0, ahead_phase_rad_, ahead_.body_m, legs);
  if (crowd_.on && is_within(time_s, crowd_.from_s, crowd_.to_s)) add_ring(time_s, robot, legs);
}

void Company::note(RealismRecord& record) const {
  const double end = drive_.duration_s();
  if (follower_.on)
    record.spoils.push_back({"follower", follower_.from_s, end_of(follower_.to_s, end)});
  if (ahead_.on) record.spoils.push_back({"ahead", ahead_.from_s, end_of(ahead_.to_s, end)});
  if (crowd_.on) record.spoils.push_back({"crowd", crowd_.from_s, end_of(crowd_.to_s, end)});
}

}  // namespace loopstone
