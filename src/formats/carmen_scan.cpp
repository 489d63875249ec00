#include "formats/carmen_scan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {
namespace {

constexpr float kNoReturn = std::numeric_limits<float>::infinity();
constexpr float kBad = std::numeric_limits<float>::quiet_NaN();
constexpr double kBeyondAnyScanner_m = 1000.0;

void translate_ranges(std::vector<float>& ranges_m, double no_return_m) {
  const auto limit_m = static_cast<float>(no_return_m);
  for (float& range_m : ranges_m) {
    if (!(range_m > 0.0F) || range_m > static_cast<float>(kBeyondAnyScanner_m)) {
      range_m = kBad;
    } else if (range_m >= limit_m) {
      range_m = kNoReturn;
    }
  }
}

BeamAngles stated_angles(const CarmenBeams& beams, std::size_t count) {
  if (beams.resolution_rad != 0.0 || count < 2) {
    return {beams.start_angle_rad, beams.resolution_rad};
  }
  return {beams.start_angle_rad, beams.field_of_view_rad / static_cast<double>(count - 1)};
}

/// CARMEN's names: robot_frontlaser_offset ahead, _side_offset to the left [m], _angular_offset
/// [rad]; a rear laser looks back unless it is said otherwise.
Pose2 mount_by_params(const CarmenSurvey& survey, int lidar, double ahead_m) {
  const std::string laser = lidar == 0 ? "robot_frontlaser" : "robot_rearlaser";
  const double aside_m = survey.param(laser + "_side_offset").value_or(0.0);
  const double turned = survey.param(laser + "_angular_offset").value_or(lidar == 0 ? 0.0 : kPi);
  const bool can_be = std::abs(aside_m) <= kFarthestMountM && std::abs(turned) <= 2.0 * kPi;
  return {ahead_m, can_be ? aside_m : 0.0, can_be ? wrap_angle(turned) : lidar == 0 ? 0.0 : kPi};
}

}  // namespace

BeamAngles carmen_beam_angles(std::size_t beams, const CarmenSurvey& survey, int lidar) {
  if (beams < 2) return {};
  const auto n = static_cast<double>(beams);
  const auto resolution_deg = lidar < 2 ? survey.param(lidar == 0 ? "laser_front_laser_resolution"
                                                                  : "laser_rear_laser_resolution")
                                        : std::nullopt;
  const bool resolution_fits = resolution_deg && *resolution_deg > 0.0 &&
                               *resolution_deg * (n - 1.0) <= 360.0 && *resolution_deg * n >= 90.0;
  if (resolution_fits) {
    // A half circle starts at -90 deg even when its last beam is left out; other fans lie about the
    // middle.
    const double increment_rad = radians(*resolution_deg);
    const bool half_circle = std::abs(*resolution_deg * n - 180.0) <= *resolution_deg * 1.01;
    return {half_circle ? -kPi / 2 : -increment_rad * (n - 1.0) / 2.0, increment_rad};
  }
  if (beams == 181 || beams == 180) return {-kPi / 2, radians(1.0)};
  if (beams == 361 || beams == 360) return {-kPi / 2, radians(0.5)};
  if (beams == 401 || beams == 400) return {-radians(0.25) * (n - 1.0) / 2.0, radians(0.25)};
  return {-kPi / 2, kPi / (n - 1.0)};
}

std::optional<std::string> carmen_offset_param(int lidar) {
  if (lidar > 1) return std::nullopt;
  return lidar == 0 ? "robot_frontlaser_offset" : "robot_rearlaser_offset";
}

std::optional<double> carmen_laser_offset(const CarmenSurvey& survey, int lidar) {
  const auto name = carmen_offset_param(lidar);
  const auto offset_m = name ? survey.param(*name) : std::nullopt;
  return offset_m && std::abs(*offset_m) <= kFarthestMountM ? offset_m : std::nullopt;
}

std::optional<Pose2> carmen_mount(const CarmenSurvey& survey, int lidar) {
  const auto offset_m = carmen_laser_offset(survey, lidar);
  const auto& by_poses = survey.mounts[static_cast<std::size_t>(lidar)];
  // Poses that are equal say nothing against an offset: many loggers wrote the robot's pose twice.
  const bool poses_tell = by_poses && !(*by_poses == Pose2{});
  if (poses_tell || (by_poses && !offset_m)) return by_poses;
  if (offset_m) return mount_by_params(survey, lidar, *offset_m);
  if (survey.pose_is_corrected) return Pose2{};
  return std::nullopt;
}

LaserScan to_laser_scan(CarmenScan&& scan, Stamp stamp, const CarmenSurvey& survey) {
  LaserScan result;
  result.stamp = stamp;
  result.lidar = lidar_of(scan.tag);
  result.robot_T_lidar = carmen_mount(survey, result.lidar);
  result.ranges_m = std::move(scan.raw_ranges_m);
  const std::size_t count = result.ranges_m.size();
  const BeamAngles angles = scan.beams ? stated_angles(*scan.beams, count)
                                       : carmen_beam_angles(count, survey, result.lidar);
  result.angle_min_rad = angles.angle_min_rad;
  result.angle_increment_rad = angles.angle_increment_rad;
  const bool states_range =
      scan.beams && scan.beams->max_range_m > 0.0 && std::isfinite(scan.beams->max_range_m);
  result.range_max_m =
      states_range ? std::min(scan.beams->max_range_m, kBeyondAnyScanner_m) : survey.no_return_m;
  translate_ranges(result.ranges_m, result.range_max_m);
  return result;
}

}  // namespace loopstone
