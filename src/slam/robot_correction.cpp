#include "loopstone/slam/robot_correction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "loopstone/slam/map_verdict.hpp"
#include "slam/mount_correction.hpp"

namespace loopstone {

RobotModel corrected_robot(RobotModel robot, const Calibration& found) {
  if (found.scale_is_off) robot.odometry_scale = found.odometry_scale;
  if (!found.beams_are_off()) return robot;
  const auto index = static_cast<std::size_t>(std::max(found.lidar, 0));
  // A laser that the robot does not have sits in its centre: see mount_of().
  while (robot.lidars.size() <= index)
    robot.lidars.push_back(
        {.name = fmt::format("laser {}", robot.lidars.size() + 1), .robot_T_lidar = Pose2{}});
  LidarMount& lidar = robot.lidars[index];
  if (found.laser_is_mirrored) lidar.upside_down = !lidar.upside_down;
  if (found.sweep_is_off) lidar.sweep_s = found.sweep_s.value;
  return robot;
}

Calibration beside(const Calibration& before, Calibration found) {
  const bool turns_over = found.laser_is_mirrored;
  if (!turns_over) found.mirror_is_in_doubt = before.mirror_is_in_doubt;
  found.laser_is_mirrored = turns_over != before.laser_is_mirrored;
  if (!found.sweep_is_off && before.sweep_is_off) {
    found.sweep_s = before.sweep_s;
    found.sweep_is_off = true;
  }
  // What a mirrored laser tells of the way is asked again.
  if (turns_over) found.scale_is_off = false;
  if (!turns_over && !found.scale_is_off && before.scale_is_off) {
    found.odometry_scale = before.odometry_scale;
    found.open_travel_error_m = before.open_travel_error_m;
    found.scale_is_off = true;
  }
  return found;
}

std::vector<std::string> tell_of_correction(const Calibration& found, MapResult& result) {
  Calibration& calibration = result.calibration;
  calibration.laser_is_mirrored = found.laser_is_mirrored;
  calibration.mirror_is_in_doubt = found.mirror_is_in_doubt;
  calibration.sweep_s = found.sweep_s;
  calibration.sweep_is_off = found.sweep_is_off;
  calibration.beams_corrected = found.beams_are_off();
  calibration.scale_is_off = found.scale_is_off;
  calibration.open_travel_error_m = found.open_travel_error_m;
  calibration.scale_corrected = found.scale_is_off;
  std::vector<std::string> words = correction_warnings(calibration);
  result.warnings.insert(result.warnings.begin(), words.begin(), words.end());
  if (calibration.mirror_is_in_doubt && !result.verdict.measures.empty())
    result.verdict = judge_map(result);
  return words;
}

}  // namespace loopstone
