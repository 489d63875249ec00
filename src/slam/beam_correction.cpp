#include "loopstone/slam/beam_correction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "slam/mount_correction.hpp"

namespace loopstone {

RobotModel corrected_beams(RobotModel robot, const Calibration& found) {
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

void tell_of_beams(const Calibration& found, MapResult& result) {
  Calibration& calibration = result.calibration;
  calibration.laser_is_mirrored = found.laser_is_mirrored;
  calibration.sweep_s = found.sweep_s;
  calibration.sweep_is_off = found.sweep_is_off;
  calibration.beams_corrected = true;
  const std::vector<std::string> words = beam_warnings(calibration);
  result.warnings.insert(result.warnings.begin(), words.begin(), words.end());
}

}  // namespace loopstone
