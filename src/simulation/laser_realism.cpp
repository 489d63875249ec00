#include "simulation/laser_realism.hpp"

#include <cmath>

#include "simulation/systematic.hpp"

namespace loopstone {
namespace {

Pose2 true_mount(const Pose2& robot_T_lidar, const RealismMount& options, Rng rng) {
  if (!options.on) return robot_T_lidar;
  const double x = systematic(options.x_m, rng);
  const double y = systematic(options.y_m, rng);
  const double yaw = systematic(options.yaw_rad, rng);
  return {robot_T_lidar.x + x, robot_T_lidar.y + y, wrap_angle(robot_T_lidar.yaw + yaw)};
}

}  // namespace

LaserRealism::LaserRealism(const World& world, const Drive& drive, const SurfaceIndex& surfaces,
                           const RobotModel& robot, const LidarMount& mount, const Realism& realism,
                           std::uint64_t seed)
    : drive_(drive),
      surfaces_(surfaces),
      realism_(realism),
      robot_T_lidar_(true_mount(mount.robot_T_lidar, realism.mount, realism_stream(seed, "mount"))),
      height_m_(mount.height_m),
      path_(world.plan, realism, world.seed),
      company_(drive, surfaces, realism, seed) {
  const auto stream = [&](std::string_view effect) { return realism_stream(seed, effect); };
  if (realism.walkers.on) {
    walkers_ =
        std::make_unique<const Crowd>(world, drive, realism.walkers.count, stream("walkers"));
  }
  if (realism.standers.on) standers_.emplace(drive, surfaces, realism.standers, stream("standers"));
  if (realism.moved.on) {
    moved_.emplace(world, drive, robot.footprint_radius_m, realism.moved, stream("moved"));
  }
  if (realism.uneven.on) floor_.emplace(realism.uneven, stream("uneven"));
  if (realism.mixed.on) mixed_.emplace(realism.mixed, stream("mixed"));
  if (realism.range.on) range_errors_.emplace(realism.range, stream("range"));
  if (realism.dropouts.on) dropouts_.emplace(realism.dropouts, stream("dropouts"));
  if (realism.blocked.on) blocked_.emplace(realism.blocked, stream("blocked"));
  if (realism.dirty.on) dirty_.emplace(realism.dirty, stream("dirty"));
}

void LaserRealism::add_people(double time_s, std::vector<Circle>& legs) const {
  if (walkers_) {
    const std::vector<Circle> more = walkers_->legs_at(time_s);
    legs.insert(legs.end(), more.begin(), more.end());
  }
  if (standers_) standers_->add_legs(time_s, legs);
  company_.add_legs(time_s, legs);
}

BeamEcho LaserRealism::meet_one(const Pose2& map_T_lidar, double angle_rad, double max_range_m,
                                const SurfaceIndex& surfaces, const FloorTilt& tilt,
                                const std::vector<Circle>& people) const {
  const double bearing = map_T_lidar.yaw + angle_rad;
  const Eigen::Vector2d direction(std::cos(bearing), std::sin(bearing));
  BeamEcho met = path_.follow(surfaces, map_T_lidar.translation(), direction, max_range_m, people);
  if (!floor_) return met;
  const double level_m = met.range_m;
  const double in_robot = robot_T_lidar_.yaw + angle_rad;
  met.range_m = floor_->range_m(level_m, in_robot, height_m_, tilt);
  if (met.range_m < level_m) {  // the floor or the ceiling, met at a grazing angle
    met.surface = SurfaceHit::kNothing;
    met.tan_incidence = met.range_m / height_m_;
  }
  return met;
}

BeamEcho LaserRealism::meet(double time_s, double angle_rad, double max_range_m,
                            const std::vector<Circle>& people) {
  const double angle = realism_.upside_down.on ? -angle_rad : angle_rad;
  const Pose2 map_T_robot = drive_.pose_at(time_s);
  const Pose2 map_T_lidar = map_T_robot * robot_T_lidar_;
  const SurfaceIndex& surfaces = moved_ ? moved_->surfaces_at(time_s) : surfaces_;
  const FloorTilt tilt = floor_ ? floor_->tilt_at(map_T_robot) : FloorTilt{};
  const auto meet_at = [&](double at_rad) {
    return meet_one(map_T_lidar, at_rad, max_range_m, surfaces, tilt, people);
  };
  const BeamEcho middle = meet_at(angle);
  if (!mixed_) return middle;
  std::array<BeamEcho, 4> parts;
  const std::array<double, 4> offsets = mixed_->parts_rad();
  for (std::size_t i = 0; i < parts.size(); ++i) parts[i] = meet_at(angle + offsets[i]);
  return mixed_->merged(middle, parts);
}

double LaserRealism::measured(const BeamEcho& met) {
  double range = met.range_m;
  if (range_errors_) range = range_errors_->measured(range, met.tan_incidence);
  if (dropouts_) range = dropouts_->measured(range, met);
  return range;
}

void LaserRealism::spoil(LaserScan& scan, double time_s) {
  if (realism_.steps.on) {
    const double step = realism_.steps.step_m;
    for (float& range : scan.ranges_m) {
      if (std::isfinite(range))
        range = static_cast<float>(std::round(static_cast<double>(range) / step) * step);
    }
  }
  if (dirty_) dirty_->spoil(scan);
  if (blocked_) blocked_->spoil(scan, time_s);
}

void LaserRealism::note(RealismRecord& record) const {
  const auto fact = [&](const char* effect, const char* name, double value) {
    record.facts.push_back({effect, name, value});
  };
  if (realism_.mount.on) {
    fact("mount", "robot_T_lidar_x_m", robot_T_lidar_.x);
    fact("mount", "robot_T_lidar_y_m", robot_T_lidar_.y);
    fact("mount", "robot_T_lidar_yaw_rad", robot_T_lidar_.yaw);
  }
  if (range_errors_) range_errors_->note(record);
  if (realism_.sweep.on) fact("sweep", "sweep_s", realism_.sweep.sweep_s);
  if (moved_) fact("moved", "things", static_cast<double>(moved_->moved()));
  if (standers_) fact("standers", "people", static_cast<double>(standers_->count()));
  if (realism_.blocked.on) {
    const double end = realism_.blocked.at_s + realism_.blocked.length_s;
    record.spoils.push_back({"blocked", realism_.blocked.at_s, end});
  }
  company_.note(record);
}

}  // namespace loopstone
