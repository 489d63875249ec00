#pragma once

#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/slam/calibration.hpp"
#include "loopstone/slam/key_scan.hpp"
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

/// Whether odometry's way is too long by a factor that was learned too late: into the calibration
/// of a run.
/// \param assumed_scale  of the robot; 1: none
void judge_scale(std::span<const KeyScan> keys, const std::deque<TrackedPose>& track,
                 double assumed_scale, MapResult& result);

/// Whether bare corridors are as long as odometry says once its scale was learned.
[[nodiscard]] bool scale_is_known(const Calibration& calibration);
/// How wrong the scale of odometry may be where the laser left a direction to it.
[[nodiscard]] double scale_sigma(const Calibration& calibration);

/// What the user should know of the laser's beams and of odometry's scale.
[[nodiscard]] std::vector<std::string> correction_warnings(const Calibration& calibration);
/// What the user should know of the mount, and of the beams.
[[nodiscard]] std::vector<std::string> calibration_warnings(const MapResult& result);

}  // namespace loopstone
