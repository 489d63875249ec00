#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/sensor/scan_points.hpp"

namespace loopstone {

/// A scan that cannot be placed (a pose that is not finite) is left out.
[[nodiscard]] inline bool usable(const PosedScan& posed) {
  return posed.scan != nullptr && posed.map_T_lidar.vector().allFinite() &&
         posed.map_T_lidar_end.vector().allFinite() && posed.map_T_robot.vector().allFinite();
}

/// What one beam says: free from start to end, and occupied there if it hit.
struct Beam {
  Eigen::Vector2d start;  ///< [m], map frame
  Eigen::Vector2d end;
  bool hit = false;
};

/// How far a beam reaches.
struct BeamReach {
  double range_m = 0.0;  ///< 0: the beam says nothing
  bool hit = false;
};

/// REP-117: a finite range within the scanner's limits is a return, +inf says that nothing is near,
/// all else is bad.
[[nodiscard]] inline BeamReach reach_of(float range, const LaserScan& scan,
                                        const OccupancyOptions& options) {
  const auto range_m = static_cast<double>(range);
  // Compared as the float that the scanner reported: 5.6 as a float lies beyond 5.6.
  const bool is_return = range > 0.0F && range >= static_cast<float>(scan.range_min_m) &&
                         range <= static_cast<float>(scan.range_max_m) && std::isfinite(range);
  if (is_return && range_m <= options.max_range_m) return {range_m, true};
  const bool nothing_near = is_return || (std::isinf(range) && range > 0.0F);
  if (!nothing_near) return {};
  double carve_m = std::min(options.no_return_carve_m, options.max_range_m);
  if (scan.range_max_m > 0.0) carve_m = std::min(carve_m, scan.range_max_m);
  return {carve_m, false};
}

/// Calls visit(Beam) for each beam that says something. Between the first and the last beam the
/// lidar moves along an arc, at constant speed.
template <typename Visit>
void for_each_beam(const PosedScan& posed, const OccupancyOptions& options, BeamTable& table,
                   Visit&& visit) {
  const LaserScan& scan = *posed.scan;
  const auto& directions = table.directions(scan);
  const std::size_t count = scan.ranges_m.size();
  const bool moves = count > 1 && !(posed.map_T_lidar == posed.map_T_lidar_end);
  const Tangent2 step = moves ? Tangent2(log(posed.map_T_lidar.inverse() * posed.map_T_lidar_end) /
                                         static_cast<double>(count - 1))
                              : Tangent2::Zero();
  // From beam to beam the lidar moves by the same small pose, so the pose of each beam follows from
  // the last one by products alone; a thousand of them lose less than 1e-12.
  const Pose2 beam_T_next = exp(step);
  const Eigen::Matrix2d step_rotation = beam_T_next.rotation();
  Eigen::Matrix2d rotation = posed.map_T_lidar.rotation();
  Eigen::Vector2d start = posed.map_T_lidar.translation();
  for (std::size_t i = 0; i < count; ++i) {
    if (moves && i > 0) {
      start += rotation * beam_T_next.translation();
      rotation = rotation * step_rotation;
    }
    const BeamReach reach = reach_of(scan.ranges_m[i], scan, options);
    if (!(reach.range_m > 0.0)) continue;
    visit(Beam{start, start + reach.range_m * (rotation * directions[i]), reach.hit});
  }
}

}  // namespace loopstone
