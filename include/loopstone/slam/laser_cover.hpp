#pragma once

#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/mapping/submap.hpp"
#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/sensor/scan_points.hpp"

namespace loopstone {

/// What of a scan does not show the surroundings.
struct LaserCover {
  std::vector<bool> beams{};  ///< empty: all show them
  bool is_fault = false;      ///< so much that it is worth a word
};

/// Tells what hangs before a laser, and who crowds about the robot, from the building: it ends
/// beams where the submap knows free space and no surface.
///   - From right in front of the laser such returns are its cover; then all from there are.
///   - From a few metres around, they are strangers, if the rest of the scan agrees with the submap
///     where the robot is expected; whole things are taken out, so far as beams beside one another
///     show them. Where the rest does not agree either, the robot is elsewhere, and nothing is
///     said; nor where its motion was guessed, for then a guess that is off looks like strangers.
/// A wall that the robot comes near to is known before it is near.
/// \param submap_T_lidar  as foretold, before the scan is aligned
/// \param is_measured     odometry foretold it
/// Cost: one pass over the ranges. Deterministic.
[[nodiscard]] LaserCover cover_of(const LaserScan& scan, const Pose2& submap_T_lidar,
                                  bool is_measured, const Submap& submap, BeamTable& beams);

/// Whether so many of a scan's beams end on who stands about the robot that it is worth a word.
[[nodiscard]] bool is_crowd(const std::vector<bool>& beams);

/// These beams tell nothing any more (NaN).
void take_out(const std::vector<bool>& beams, LaserScan& scan);

}  // namespace loopstone
