#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "loopstone/sensor/messages.hpp"
#include "loopstone/slam/mapper.hpp"

namespace loopstone::test {

/// Submaps that are full after a few scans.
[[nodiscard]] inline MapOptions short_submaps() {
  MapOptions options;
  options.front_end.submap_length_m = 0.5;
  options.map.resolution_m = 0.25;
  return options;
}

/// What a robot hears that drives towards a wall, between two others, 0.1 m and 0.1 s a scan:
/// odometry, gyro, and scan number `i`.
[[nodiscard]] inline std::vector<SensorMessage> passage_messages(int i) {
  const Stamp stamp{i * 100'000'000LL};
  LaserScan scan{.stamp = stamp,
                 .angle_min_rad = -1.5,
                 .angle_increment_rad = 0.1,
                 .range_min_m = 0.1,
                 .range_max_m = 10.0};
  for (std::size_t beam = 0; beam < 31; ++beam) {
    const double angle = -1.5 + 0.1 * static_cast<double>(beam);
    const double aside = 1.5 / std::max(0.01, std::abs(std::sin(angle)));
    const double ahead = (4.0 - 0.1 * i) / std::max(0.01, std::cos(angle));
    scan.ranges_m.push_back(static_cast<float>(std::min(aside, ahead)));
  }
  return {OdometryPose{stamp, {0.1 * i, 0.0, 0.0}}, ImuSample{stamp, {0.0, 0.0, 0.01}}, scan};
}

/// Scans `from` to before `to` of that drive.
inline void drive_through_a_passage(Mapper& mapper, int from, int to) {
  for (int i = from; i < to; ++i) {
    for (const SensorMessage& message : passage_messages(i)) mapper.add(message);
  }
}

}  // namespace loopstone::test
