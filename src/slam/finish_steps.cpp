#include "slam/finish_steps.hpp"

#include <algorithm>
#include <exception>
#include <span>
#include <utility>
#include <vector>

#include "loopstone/base/release_memory.hpp"
#include "loopstone/slam/surface_adjustment.hpp"
#include "slam/map_finish.hpp"
#include "slam/mount_correction.hpp"
#include "slam/path_drift.hpp"
#include "slam/stopwatch.hpp"

namespace loopstone {

namespace {

bool goes_on(const FinishCalls& calls, int stage) {
  return !calls.goes_on_to || calls.goes_on_to(stage);
}

void tell_drives(std::size_t scans, const std::deque<TrackedPose>& track, MapResult& result) {
  std::size_t end = scans;
  for (auto drive = result.drives.rbegin(); drive != result.drives.rend(); ++drive) {
    drive->scans = static_cast<std::int64_t>(end - drive->first_scan);
    if (drive->scans > 0) drive->begins = track[drive->first_scan].stamp;
    for (const PathBreak& gap : result.breaks) {
      if (gap.cause == BreakCause::kNewDrive && gap.to_scan >= drive->first_scan &&
          gap.to_scan < end)
        drive->closures = gap.closures;
    }
    end = drive->first_scan;
  }
  std::erase_if(result.drives, [](const MappedDrive& drive) { return drive.scans == 0; });
}

/// Landmarks and the like, by what the key scans show.
void add_to_graph(const SettledMap& map, const GraphAddition& addition, MapResult& result) {
  if (!addition) return;
  const std::vector<KeyView> keys = key_views(map.chain.submaps(), map.track);
  if (keys.size() == result.graph.poses.size()) addition(result.graph, keys);
}

/// All scans on the map, by the mount that the drive tells.
PlacedScans place(const SettledMap& map, MapResult& result) {
  const std::span<const SubmapRecord> submaps = map.chain.submaps();
  PlacedScans placed =
      place_scans(map.track, map.chain.keys(), result.graph.poses, result.breaks, submaps);
  find_calibration(map.chain, map.track, map.robot, map.options, result);
  const Calibration& found = result.calibration;
  if (found.is_corrected)
    correct_mount(found.robot_T_lidar_given, found.robot_T_lidar(), result, placed);
  return placed;
}

/// Scans that are not used any more are not drawn.
void leave_out(const SettledMap& map, const FinishCalls& calls, PlacedScans& placed) {
  if (!calls.ignores) return;
  std::vector<bool> used;
  for (const SubmapRecord& submap : map.chain.submaps()) {
    submap.scans.for_each(
        [&](const MappedScan& mapped) { used.push_back(!calls.ignores(mapped.index)); });
  }
  std::size_t place = 0;
  std::erase_if(placed.on_map, [&](const PosedScan&) { return !used[place++]; });
}

/// Tells all in another frame of the map.
void move_frame(const FinishCalls& calls, MapResult& result, PlacedScans& placed,
                PoseGraph& solved) {
  if (!calls.frame) return;
  const Pose2 new_T_map = calls.frame(result);
  if (new_T_map == Pose2{}) return;
  for (Pose2& pose : result.graph.poses) pose = new_T_map * pose;
  for (Eigen::Vector2d& landmark : result.graph.landmarks) landmark = new_T_map * landmark;
  for (Pose2& pose : solved.poses) pose = new_T_map * pose;
  result.covariances.turn_axes(new_T_map.yaw);
  Trajectory trajectory;
  trajectory.reserve(placed.trajectory.size());
  for (const StampedPose2& pose : placed.trajectory.poses())
    trajectory.append(pose.stamp, new_T_map * pose.pose);
  placed.trajectory = std::move(trajectory);
  for (PosedScan& scan : placed.on_map) {
    scan.map_T_lidar = new_T_map * scan.map_T_lidar;
    scan.map_T_lidar_end = new_T_map * scan.map_T_lidar_end;
    scan.map_T_robot = new_T_map * scan.map_T_robot;
  }
}

/// The figures that follow from the finished trajectory and graph.
void count(MapResult& result) {
  auto& statistics = result.statistics;
  for (const auto& closure : result.loop_closures) {
    ++(closure.stands() ? statistics.loop_closures_accepted : statistics.loop_closures_rejected);
  }
  if (!result.trajectory.empty()) {
    statistics.duration_s =
        (result.trajectory.back().stamp - result.trajectory.front().stamp).seconds();
  }
  statistics.graph_cost = graph_cost(result.graph);
}

void draw(const SettledMap& map, const FinishCalls& calls, std::span<const PosedScan> scans,
          Threads threads, MapResult& result) {
  const Stopwatch rendering;
  try {
    result.map = calls.draw ? calls.draw(scans)
                            : build_occupancy_map(scans, map.robot.footprint_radius_m,
                                                  map.options.map, threads);
    if (calls.touch_up) calls.touch_up(result);
  } catch (const std::exception& error) {
    result.map_failure = error.what();
  }
  result.statistics.rendering_s = rendering.seconds();
}

/// What scans, graph and path say of the map.
void judge(const PoseGraph& solved, std::span<const PosedScan> scans, Threads threads,
           MapResult& result) {
  result.quality = assess_map(scans, threads);
  result.ties = find_ties_of(solved, {.stamps = result.node_stamps,
                                      .drifts = result.drifts,
                                      .surfaces = result.path_surfaces,
                                      .scale_sigma = scale_sigma(result.calibration),
                                      .agreeing = result.quality.agreeing,
                                      .contradictions = result.quality.contradictions,
                                      .loops = result.graph_quality.loops,
                                      .reduced_chi2 = result.graph_quality.reduced_chi2});
  result.verdict = judge_map(result);
}

PathWeakness weakness_of(const KeyChain& chain) {
  PathWeakness weakness;
  for (const KeyScan& key : chain.keys()) {
    weakness.broken.push_back(key.across.has_value());
    weakness.open.push_back(rests_on_odometry(key.covariance));
  }
  return weakness;
}

}  // namespace

MapResult begin_result(const SettledMap& map, SettledGraph settled) {
  MapResult result = map.counted;
  result.graph = std::move(settled.graph);
  result.loop_closures = std::move(settled.closures);
  std::vector<std::size_t> node_scans;
  for (const KeyScan& key : map.chain.keys()) {
    result.node_stamps.push_back(key.stamp);
    node_scans.push_back(key.scan);
  }
  find_ties(result.breaks, result.graph, node_scans);
  tell_drives(map.track.size(), map.track, result);
  MapStatistics& statistics = result.statistics;
  statistics.key_scans_thinned =
      statistics.key_scans - static_cast<std::int64_t>(node_scans.size());
  return result;
}

void adjust(const SettledMap& map, const FinishCalls& calls, Threads threads, MapResult& result) {
  const SurfaceAdjustmentOptions& options = map.options.adjustment;
  const PathWeakness weakness = weakness_of(map.chain);
  if (!options.enabled) {
    result.covariances = PoseCovariances(result.graph, nullptr, weakness.broken);
    return;
  }
  const Stopwatch watch;
  std::vector<std::vector<SurfacePoint>> surfaces = key_surfaces(
      map.chain.submaps(),
      {.range_max_m = map.options.front_end.range_max_m, .points_max = options.points_max});
  if (calls.ignores) {
    const std::vector<KeyScan> keys = map.chain.keys();
    for (std::size_t i = 0; i < keys.size(); ++i)
      if (calls.ignores(keys[i].scan)) surfaces[i].clear();
  }
  auto adjusted = adjust_to_surfaces(result.graph, surfaces, options, threads, weakness);
  result.graph.poses = std::move(adjusted.poses);
  result.graph.landmarks = std::move(adjusted.landmarks);
  result.covariances = std::move(adjusted.covariances);
  result.path_surfaces = std::move(adjusted.path);
  result.statistics.surface_spread_before_m = adjusted.spread_before_m;
  result.statistics.surface_spread_m = adjusted.spread_after_m;
  result.statistics.adjustment_s = watch.seconds();
}

void find_calibration(const KeyChain& chain, const std::deque<TrackedPose>& track,
                      const RobotModel& robot, const MapOptions& options, MapResult& result) {
  if (!options.calibration) return;
  const AssumedMounts mounts = assumed_mounts(chain.submaps());
  if (options.front_end.odometry != OdometryUse::kIgnore)
    result.calibration = calibrate_run(track, mounts, result);
  judge_scale(chain.keys(), track, robot.odometry_scale, result);
  judge_beams(track, mounts, chain.submaps(), result);
}

MapResult place_keys(const SettledMap& map, SettledGraph settled, const FinishCalls& calls,
                     Threads threads) {
  MapResult result = begin_result(map, std::move(settled));
  adjust(map, calls, threads, result);
  (void)place(map, result);
  return result;
}

MapResult finish_settled(const SettledMap& map, SettledGraph settled, const FinishCalls& calls,
                         Threads threads) {
  bool complete = true;
  const auto goes_on_to = [&](int stage) { return complete = complete && goes_on(calls, stage); };
  MapResult result = begin_result(map, std::move(settled));

  release_unused_memory();
  if (complete) add_to_graph(map, calls.addition, result);
  PoseGraph solved = result.graph;
  if (goes_on_to(1)) adjust(map, calls, threads, result);
  // How well edges agree is judged at the graph's own solution: the adjustment knows more than they
  // do.
  const Stopwatch judging_graph;
  if (goes_on_to(2))
    result.graph_quality = assess_graph(solved, result.graph.poses, result.loop_closures);
  result.statistics.judging_s = judging_graph.seconds();
  result.loop_closures = at_poses_of(result.graph, std::move(result.loop_closures));

  PlacedScans placed = place(map, result);
  leave_out(map, calls, placed);
  move_frame(calls, result, placed, solved);
  const double scale = scale_is_known(result.calibration) ? result.calibration.odometry_scale : 0.0;
  result.drifts = map.chain.drifts({map.track, scale, result.breaks});
  result.trajectory = std::move(placed.trajectory);
  result.odometry = std::move(placed.odometry);
  if (calls.track_is_told) calls.track_is_told();  // it is in the trajectories now
  release_unused_memory();

  if (!goes_on_to(3)) placed.on_map = some_of(placed.on_map);
  draw(map, calls, placed.on_map, threads, result);
  count(result);

  release_unused_memory();
  const Stopwatch judging;
  if (goes_on_to(4) && result.map_failure.empty()) judge(solved, placed.on_map, threads, result);
  result.statistics.judging_s += judging.seconds();
  result.warnings = warnings_of(result, map.options, map.has_gyro);
  result.complete = complete;
  return result;
}

}  // namespace loopstone
