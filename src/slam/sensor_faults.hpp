#pragma once

#include <string>
#include <vector>

#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// What accuses a sensor.
struct SensorFaultNumbers {
  double brief_s = 1.0;
  int many_repeats = 100;
  double scale_off = 0.06;
  double mount_off_deg = 3.0;
  double same_correlation = 0.4;
};
inline constexpr SensorFaultNumbers kSensorFaults{};

template <typename Visitor>
void visit_numbers(const SensorFaultNumbers& n, Visitor&& visit) {
  visit("brief_s", n.brief_s, "chosen: shorter faults of the laser are beneath notice");
  visit("many_repeats", n.many_repeats,
        "chosen: the same scan so often in a row, where no odometry tells whether the robot stood");
  visit("scale_off", n.scale_off,
        "chosen: wheels measured with a ruler are right to some per cent; recorded logs of "
        "calibrated robots lie within 4 %");
  visit("mount_off_deg", n.mount_off_deg, "chosen: a mount set by eye is right to a degree or two");
  visit("same_correlation", n.same_correlation,
        "chosen: correlation at which wheels and gyro tell the same, or the opposite: of thousands "
        "of turns no chance; slipping wheels of a robot that hardly turns reach 0.6");
}

/// Faults by which the map itself may be wrong, though its scans agree with one another: of the
/// laser, of its mount, or of either the laser or odometry where the data can't tell which. Plain
/// words, with times since the first scan.
[[nodiscard]] std::vector<std::string> sensor_faults(const MapResult& result);

/// Scans that were not used, all or in part, since the laser was blocked, covered or frozen. They
/// are not on the map; what the path lost meanwhile is in its covariances. As sensor_faults().
[[nodiscard]] std::vector<std::string> unused_scans(const MapResult& result);

}  // namespace loopstone
