#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/sensor/laser_scan.hpp"

namespace loopstone {

/// The directions of a scan's beams, computed once for as long as the scanner stays the same.
class BeamTable {
 public:
  /// Unit vectors in the lidar frame, one a beam.
  [[nodiscard]] const std::vector<Eigen::Vector2d>& directions(const LaserScan& scan);

 private:
  double angle_min_rad_ = 0.0;
  double angle_increment_rad_ = 0.0;
  std::vector<Eigen::Vector2d> directions_{};
};

/// From the first beam to the last; 0: unknown, or all at once; negative: the last beam came first.
[[nodiscard]] inline double sweep_seconds(const LaserScan& scan) {
  return scan.time_increment_s * static_cast<double>(scan.ranges_m.size());
}

/// From the scan before to this one, for velocities. No scanner begins its next sweep before the
/// last one is over: stamps that say so, of scans that came in a burst, are wrong.
[[nodiscard]] inline double seconds_between_scans(Stamp before, const LaserScan& scan) {
  return std::max((scan.stamp - before).seconds(), std::abs(sweep_seconds(scan)));
}

/// A piece of surface: where it is, where it faces, and how much it can be relied on.
struct SurfacePoint {
  Eigen::Vector2f position;  ///< [m]
  Eigen::Vector2f normal;    ///< unit, towards free space (the side it was seen from)
  float weight =
      /// 1: normal fitted to neighbours; less: a small thing, its normal a guess along the beam
      1.0F;

  template <typename Archive>
  void archive(Archive& a) {
    a(position, normal, weight);
  }
};

/// The returns of a scan as points in the robot frame at the scan's stamp, in beam order; beams
/// without a return are left out.
///
/// \param velocity  of the robot in its own frame [m/s, m/s, rad/s]; undoes the motion during the
///                  sweep when the scan has a time increment (zero: no correction)
[[nodiscard]] std::vector<Eigen::Vector2d> scan_points(const LaserScan& scan,
                                                       const Pose2& robot_T_lidar,
                                                       const Tangent2& velocity = Tangent2::Zero());

/// How surfaces are read from a scan.
struct SurfaceOptions {
  double support_m = 0.12;    ///< neighbours up to this far along the surface define the normal
  double spacing_m = 0.05;    ///< points closer than this to the last one kept are merged into it
  double range_max_m = 60.0;  ///< farther returns are left out
  int points_max = 360;       ///< spacing grows until there are no more than this
};

/// Surfaces seen by a scan, in the robot frame at the scan's stamp, thinned to an even spacing.
/// Each point lies on the line through its neighbours, so noise is averaged, not thrown away;
/// breaks in the surface (neighbours farther apart than a slanted wall explains) are not bridged,
/// and lone returns on a wall seen at a grazing angle, whose normal can't be told, are left out.
/// Cost: O(beams).
[[nodiscard]] std::vector<SurfacePoint> surface_points(const LaserScan& scan,
                                                       const Pose2& robot_T_lidar,
                                                       const Tangent2& velocity,
                                                       const SurfaceOptions& options,
                                                       BeamTable& beams);

}  // namespace loopstone
