#include "loopstone/sensor/mounted_scan.hpp"

#include <cstddef>
#include <utility>
#include <variant>

namespace loopstone {

std::optional<LaserScan> as_mounted(const LaserScan& scan, const RobotModel& robot) {
  const auto index = static_cast<std::size_t>(scan.lidar);
  if (scan.lidar < 0 || index >= robot.lidars.size()) return {};
  const LidarMount& lidar = robot.lidars[index];
  const bool takes_sweep =
      lidar.sweep_s != 0.0 && scan.time_increment_s == 0.0 && !scan.ranges_m.empty();
  if (!lidar.upside_down && !takes_sweep) return {};
  LaserScan mounted = scan;
  if (lidar.upside_down) {
    mounted.angle_min_rad = -scan.angle_min_rad;
    mounted.angle_increment_rad = -scan.angle_increment_rad;
  }
  if (takes_sweep)
    mounted.time_increment_s = lidar.sweep_s / static_cast<double>(scan.ranges_m.size());
  return mounted;
}

std::optional<SensorMessage> as_mounted(const SensorMessage& message, const RobotModel& robot) {
  const auto* const scan = std::get_if<LaserScan>(&message);
  if (scan == nullptr) return {};
  std::optional<LaserScan> mounted = as_mounted(*scan, robot);
  if (!mounted) return {};
  return SensorMessage(std::move(*mounted));
}

}  // namespace loopstone
