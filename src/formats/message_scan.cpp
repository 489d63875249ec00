#include "formats/message_scan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/ros_geometry.hpp"
#include "formats/topic_choice.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/messages/message_codec.hpp"

namespace loopstone {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kBad = std::numeric_limits<float>::quiet_NaN();
/// For scanners that do not state how far they see.
constexpr double kFarthestM = 100.0;
/// A sweep of more than so many periods is a wrong unit.
constexpr double kMostPeriods = 1.5;

/// Limits, angles and times that all kinds of scans state in the same fields.
template <typename Message>
LaserScan head_of(const Message& message, double period_s, ScanRemarks& remarks) {
  const auto beams = static_cast<double>(message.ranges.size());
  LaserScan scan{.stamp = message.header.stamp,
                 .angle_min_rad = static_cast<double>(message.angle_min),
                 .angle_increment_rad = static_cast<double>(message.angle_increment),
                 .range_min_m = static_cast<double>(message.range_min),
                 .range_max_m = static_cast<double>(message.range_max),
                 .time_increment_s = static_cast<double>(message.time_increment)};
  if (message.ranges.empty()) throw MessageError(0, "a scan without beams");
  if (!std::isfinite(scan.angle_min_rad)) throw MessageError(0, "the first angle is no number");
  const double span = static_cast<double>(message.angle_max) - scan.angle_min_rad;
  if (!std::isfinite(scan.angle_increment_rad) ||
      (scan.angle_increment_rad == 0.0 && beams > 1.0)) {
    if (!std::isfinite(span) || span == 0.0) throw MessageError(0, "the beams have no directions");
    scan.angle_increment_rad = span / std::max(1.0, beams - 1.0);
    remarks.add("scans do not state the angle between beams: it follows from the first and last");
  } else if (std::isfinite(span) && std::abs(scan.angle_increment_rad * (beams - 1.0) - span) >
                                        2.0 * std::abs(scan.angle_increment_rad) + 1e-3) {
    remarks.add(
        "the number of beams does not fit the first and last angle: the angle between "
        "beams is believed");
  }
  if (std::abs(scan.angle_increment_rad) * (beams - 1.0) > 4.0 * kPi) {
    throw MessageError(0, "the beams go round more than twice");
  }
  if (!(scan.range_min_m >= 0.0) || !std::isfinite(scan.range_min_m)) scan.range_min_m = 0.0;
  if (!(scan.range_max_m > scan.range_min_m)) {
    scan.range_max_m = kFarthestM;
    remarks.add("scans do not state how far the laser sees: 100 m are taken");
  }
  scan.range_max_m = std::min(scan.range_max_m, 10.0 * kFarthestM);
  const double sweep_s = std::abs(scan.time_increment_s) * beams;
  if (!std::isfinite(sweep_s) || (period_s > 0.0 && sweep_s > kMostPeriods * period_s)) {
    scan.time_increment_s = 0.0;
    remarks.add(
        "the time between beams can't be: the sweep would last longer than the time from "
        "scan to scan; it is taken for unknown");
  }
  return scan;
}

float by_convention(float range_m, double range_min_m, double range_max_m) {
  const auto value = static_cast<double>(range_m);
  if (std::isnan(range_m) || value < range_min_m) return kBad;  // -inf: too near to measure
  if (value >= range_max_m * (1.0 - 1e-6)) return kInfinity;
  return value > 0.0 ? range_m : kBad;
}

/// The echo of a beam that counts; NaN when there is none.
float echo_of(const msg::MultiEchoLaserScan& message, std::size_t beam, EchoUse use) {
  const std::vector<float>& echoes = message.ranges[beam].echoes;
  if (echoes.empty()) return kBad;
  if (use == EchoUse::kFirst || beam >= message.intensities.size()) return echoes.front();
  const std::vector<float>& strengths = message.intensities[beam].echoes;
  if (strengths.size() != echoes.size()) return echoes.front();
  const auto strongest = std::ranges::max_element(strengths) - strengths.begin();
  return echoes[static_cast<std::size_t>(strongest)];
}

}  // namespace

LaserScan to_laser_scan(const msg::LaserScan& message, double period_s, ScanRemarks& remarks) {
  LaserScan scan = head_of(message, period_s, remarks);
  scan.ranges_m.reserve(message.ranges.size());
  for (const float range_m : message.ranges) {
    scan.ranges_m.push_back(by_convention(range_m, scan.range_min_m, scan.range_max_m));
  }
  return scan;
}

LaserScan to_laser_scan(const msg::MultiEchoLaserScan& message, EchoUse echo, double period_s,
                        ScanRemarks& remarks) {
  LaserScan scan = head_of(message, period_s, remarks);
  scan.ranges_m.reserve(message.ranges.size());
  for (std::size_t beam = 0; beam < message.ranges.size(); ++beam) {
    scan.ranges_m.push_back(
        by_convention(echo_of(message, beam, echo), scan.range_min_m, scan.range_max_m));
  }
  return scan;
}

msg::LaserScan to_message(const LaserScan& scan, const std::string& frame) {
  const auto beams = static_cast<double>(scan.ranges_m.size());
  msg::LaserScan message{.header = {.stamp = scan.stamp, .frame_id = frame}};
  message.angle_min = static_cast<float>(scan.angle_min_rad);
  message.angle_increment = static_cast<float>(scan.angle_increment_rad);
  message.angle_max = static_cast<float>(scan.angle_min_rad +
                                         std::max(0.0, beams - 1.0) * scan.angle_increment_rad);
  message.time_increment = static_cast<float>(scan.time_increment_s);
  message.scan_time = static_cast<float>(scan.time_increment_s * beams);
  message.range_min = static_cast<float>(scan.range_min_m);
  message.range_max = static_cast<float>(scan.range_max_m);
  message.ranges = scan.ranges_m;
  message.intensities = scan.intensities;
  return message;
}

void place(const Pose3& base_T_laser, LaserScan& scan) {
  if (is_upside_down(base_T_laser)) {
    scan.angle_min_rad = -scan.angle_min_rad;
    scan.angle_increment_rad = -scan.angle_increment_rad;
  }
  scan.robot_T_lidar = to_pose2(base_T_laser);
}

HeightRange slice_about(const Pose3& base_T_laser) {
  constexpr double kHalfM = 0.5;
  constexpr double kAboveFloorM = 0.2;   // a floor that is not even, a robot that nods
  constexpr double kBelowLaserM = 0.05;  // of scanners that sit low
  constexpr double kUnknownHalfM = 0.2;
  const double height_m = base_T_laser.translation.z();
  if (height_m < 2.0 * kBelowLaserM) return {height_m - kUnknownHalfM, height_m + kUnknownHalfM};
  const double above_floor_m = std::min(kAboveFloorM, height_m - kBelowLaserM);
  return {std::max(height_m - kHalfM, above_floor_m), height_m + kHalfM};
}

}  // namespace loopstone
