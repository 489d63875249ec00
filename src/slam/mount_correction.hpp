#pragma once

#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/slam/calibration.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/submap_record.hpp"
#include "loopstone/slam/tracked_pose.hpp"
#include "slam/map_finish.hpp"

namespace loopstone {

/// Where the lasers of a run sat, as it was assumed.
struct AssumedMounts {
  std::optional<Pose2> first{};  ///< robot_T_lidar
  int lidar = 0;                 ///< whose
  bool several = false;
  /// The log itself says that the laser is the robot's centre: that is whose path it asks for.
  bool laser_is_centre = false;
};
[[nodiscard]] AssumedMounts assumed_mounts(std::span<const SubmapRecord> submaps);

/// calibrate(), without the times when the laser did not hold the pose or odometry stood still.
[[nodiscard]] Calibration calibrate_run(const std::deque<TrackedPose>& track,
                                        const AssumedMounts& mounts, const MapResult& result);

/// Tells path, graph and closures anew by the robot's true centre, so that walls and scans stay
/// where they are to one another. The first pose of the path stays the origin of the map: with the
/// mount's yaw the map turns.
void correct_mount(const Pose2& given, const Pose2& corrected, MapResult& result,
                   PlacedScans& placed);

/// Whether the laser is mirrored, and its sweep: into the calibration of a run.
void judge_beams(const std::deque<TrackedPose>& track, const AssumedMounts& mounts,
                 std::span<const SubmapRecord> submaps, MapResult& result);

/// What the user should know of the laser's beams.
[[nodiscard]] std::vector<std::string> beam_warnings(const Calibration& calibration);
/// What the user should know of the mount, and of the beams.
[[nodiscard]] std::vector<std::string> calibration_warnings(const MapResult& result);

}  // namespace loopstone
