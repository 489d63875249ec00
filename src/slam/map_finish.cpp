#include "slam/map_finish.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "loopstone/sensor/scan_points.hpp"
#include "slam/break_warnings.hpp"
#include "slam/drift_correction.hpp"
#include "slam/local_verdicts.hpp"
#include "slam/mount_correction.hpp"
#include "slam/odometry_warnings.hpp"
#include "slam/posed_scan.hpp"
#include "slam/sensor_faults.hpp"

namespace loopstone {

namespace {

/// So many are drawn in half a second and show every wall.
constexpr std::size_t kMostScansInterrupted = 4000;

template <typename Visit>
void for_each_scan(std::span<const SubmapRecord> submaps, Visit&& visit) {
  for (const SubmapRecord& submap : submaps) submap.scans.for_each(visit);
}

/// From the scan before to the one after.
Tangent2 velocity_at(const std::deque<TrackedPose>& track, std::size_t index) {
  if (track.empty()) return Tangent2::Zero();
  const TrackedPose& before = track[index > 0 ? index - 1 : 0];
  const TrackedPose& after = track[std::min(index + 1, track.size() - 1)];
  const double seconds = (after.stamp - before.stamp).seconds();
  if (!(seconds > 0.0)) return Tangent2::Zero();
  return log(before.local_T_robot.inverse() * after.local_T_robot) / seconds;
}

/// How the run fared.
std::vector<std::string> run_warnings(const MapResult& result, const MapOptions& options,
                                      bool has_gyro) {
  const MapStatistics& s = result.statistics;
  std::vector<std::string> warnings;
  const auto share = [&](std::int64_t count) {
    return std::to_string(count) + " of " + std::to_string(s.scans) + " scans";
  };
  const bool ignored = options.front_end.odometry == OdometryUse::kIgnore;
  if (s.scans > 0 && (ignored || result.odometry.empty())) {
    const std::string none =
        ignored ? "odometry was left out as asked: " : "no odometry in the log: ";
    warnings.push_back(none + (has_gyro && !ignored
                                   ? "the gyro tells the heading, distances are guessed"
                                   : "the motion between scans is guessed from the last one"));
  }
  if (s.scans_dropped > 0) {
    warnings.push_back(share(s.scans_dropped) +
                       " had too few returns to be used; odometry bridged them");
  }
  if (s.searches * 50 > s.scans) {
    warnings.push_back(share(s.searches) +
                       " fitted so badly that a search had to check them; look for places where "
                       "the map is blurred");
  }
  if (s.degenerate_travel_m > 0.05 * s.path_length_m && s.degenerate_travel_m > 1.0) {
    warnings.push_back(std::to_string(std::lround(s.degenerate_travel_m)) +
                       " m of the path ran where the laser leaves one direction open (corridors); "
                       "there the map is as long as odometry says");
  }
  if (options.loop_closure && s.loop_closures_accepted == 0 && s.path_length_m > 30.0) {
    warnings.emplace_back("no place was recognised a second time: drift was not corrected");
  }
  if (auto coarser = coarser_than_asked(result.map, options.map)) {
    warnings.push_back(std::move(*coarser));
  }
  return warnings;
}

}  // namespace

std::vector<std::vector<SurfacePoint>> key_surfaces(std::span<const SubmapRecord> submaps,
                                                    const SurfaceOptions& options) {
  std::vector<std::vector<SurfacePoint>> surfaces;
  BeamTable beams;
  for_each_scan(submaps, [&](const MappedScan& mapped) {
    if (!mapped.is_key) return;
    surfaces.push_back(
        surface_points(mapped.scan, mapped.robot_T_lidar, sweep_velocity(mapped), options, beams));
  });
  return surfaces;
}

std::vector<KeyView> key_views(std::span<const SubmapRecord> submaps,
                               const std::deque<TrackedPose>& track) {
  std::vector<KeyView> keys;
  for_each_scan(submaps, [&](const MappedScan& mapped) {
    if (!mapped.is_key) return;
    keys.push_back({&mapped.scan, mapped.robot_T_lidar, velocity_at(track, mapped.index)});
  });
  return keys;
}

PlacedScans place_scans(const std::deque<TrackedPose>& track, std::vector<KeyScan> keys,
                        std::span<const Pose2> map_T_key, std::span<const PathBreak> breaks,
                        std::span<const SubmapRecord> submaps) {
  const DriftCorrection correction(std::move(keys), map_T_key, breaks);
  PlacedScans placed;
  placed.trajectory.reserve(track.size());
  placed.odometry.reserve(track.empty() || !track.back().odom_T_robot ? 0 : track.size());
  for (std::size_t i = 0; i < track.size(); ++i) {
    const auto& [stamp, local_T_robot, odom_T_robot] = track[i];
    placed.trajectory.append(stamp, correction.at(i, stamp, local_T_robot) * local_T_robot);
    if (odom_T_robot) placed.odometry.append(stamp, *odom_T_robot);
  }
  for_each_scan(submaps, [&](const MappedScan& mapped) {
    const Pose2 map_T_local = correction.at(mapped.index, mapped.scan.stamp, mapped.local_T_robot);
    placed.on_map.push_back(posed(mapped, map_T_local));
  });
  return placed;
}

std::vector<PosedScan> some_of(std::span<const PosedScan> scans) {
  const std::size_t step = scans.size() / kMostScansInterrupted + 1;
  std::vector<PosedScan> some;
  for (std::size_t i = 0; i < scans.size(); i += step) some.push_back(scans[i]);
  return some;
}

std::vector<LoopClosure> at_poses_of(const PoseGraph& graph, std::vector<LoopClosure> closures) {
  for (LoopClosure& closure : closures) {
    if (closure.chi2) closure.chi2 = chi2_at(closure, graph.poses);
  }
  return closures;
}

std::vector<std::string> warnings_of(const MapResult& result, const MapOptions& options,
                                     bool has_gyro) {
  std::vector<std::string> all;
  for (auto& warnings : {break_warnings(result), unused_scans(result), sensor_faults(result),
                         calibration_warnings(result), odometry_warnings(result),
                         local_warnings(result), run_warnings(result, options, has_gyro)}) {
    all.insert(all.end(), warnings.begin(), warnings.end());
  }
  return all;
}

}  // namespace loopstone
