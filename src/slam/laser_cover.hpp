#pragma once

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/mapping/submap.hpp"
#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/sensor/scan_points.hpp"

namespace loopstone {

/// Whether part of what a laser sees is its own cover, something that hangs over it, or people who
/// crowd about it: returns from right in front of it, where the submap knows free space and no
/// surface. A wall that the robot drives along is known to be there before it is so near.
/// \param submap_T_lidar  as foretold, before the scan is aligned
/// Cost: one pass over the ranges. Deterministic.
[[nodiscard]] bool is_covered(const LaserScan& scan, const Pose2& submap_T_lidar,
                              const Submap& submap, BeamTable& beams);

/// What is nearer than a cover can be tells nothing any more (NaN).
void take_out_cover(LaserScan& scan);

}  // namespace loopstone
