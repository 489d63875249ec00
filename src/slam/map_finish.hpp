#pragma once

#include <deque>
#include <span>
#include <string>
#include <vector>

#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/slam/graph_addition.hpp"
#include "loopstone/slam/key_scan.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/submap_record.hpp"
#include "loopstone/slam/tracked_pose.hpp"

// The steps that end a run: each takes what it needs and returns what it made.

namespace loopstone {

/// The surfaces of each key scan, in its own frame, straightened by the motion during its sweep.
/// Not those that the front end aligned: these are fewer, and straightened by the final motion
/// where those had the expected one. Keeping them instead would cost memory for all key scans (2.4
/// kB each, a tenth of what a run takes) to save what docs/benchmarks.md calls "surfaces of the
/// scan", some hundredths of a millisecond each.
[[nodiscard]] std::vector<std::vector<SurfacePoint>> key_surfaces(
    std::span<const SubmapRecord> submaps, const SurfaceOptions& options);

/// Each key scan, and how the robot moved then.
[[nodiscard]] std::vector<KeyView> key_views(std::span<const SubmapRecord> submaps,
                                             const std::deque<TrackedPose>& track);

struct PlacedScans {
  Trajectory trajectory{};          ///< map_T_robot at every scan
  Trajectory odometry{};            ///< odom_T_robot at every scan
  std::vector<PosedScan> on_map{};  ///< those that the map is drawn from; they point into `submaps`
};
/// Puts every scan on the map: between key scans their corrections are blended.
/// \param map_T_key  of each key scan
[[nodiscard]] PlacedScans place_scans(const std::deque<TrackedPose>& track,
                                      std::vector<KeyScan> keys, std::span<const Pose2> map_T_key,
                                      std::span<const PathBreak> breaks,
                                      std::span<const SubmapRecord> submaps);

/// A few of the scans, evenly: who interrupts a run does not wait for the map of all.
[[nodiscard]] std::vector<PosedScan> some_of(std::span<const PosedScan> scans);

/// The closures with their disagreement at the graph's poses.
[[nodiscard]] std::vector<LoopClosure> at_poses_of(const PoseGraph& graph,
                                                   std::vector<LoopClosure> closures);

/// What the user should know about the run, in plain words: what went wrong first, then how it
/// fared.
[[nodiscard]] std::vector<std::string> warnings_of(const MapResult& result,
                                                   const MapOptions& options, bool has_gyro);

}  // namespace loopstone
