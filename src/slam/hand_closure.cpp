#include "slam/hand_closure.hpp"

#include <cmath>

#include "loopstone/base/hypotenuse.hpp"
#include "slam/loop_candidates.hpp"
#include "slam/posed_scan.hpp"

namespace loopstone {

namespace {

/// Between neighbours on the path; nothing where the laser did not hold it.
std::optional<double> step_m(const KeyScan& before, const KeyScan& after) {
  if (after.across || after.starts_drive) return {};
  const Pose2 motion = before.local_T_robot.inverse() * after.local_T_robot;
  return hypotenuse(motion.x, motion.y);
}

}  // namespace

NodeRange nodes_around(std::size_t node, double reach_m, const EditedPath& path) {
  NodeRange range{node, node};
  for (double way_m = 0.0; range.first > 0; --range.first) {
    const auto step = step_m(path.keys[range.first - 1], path.keys[range.first]);
    if (!step || (way_m += *step) > reach_m) break;
  }
  for (double way_m = 0.0; range.last + 1 < path.keys.size(); ++range.last) {
    const auto step = step_m(path.keys[range.last], path.keys[range.last + 1]);
    if (!step || (way_m += *step) > reach_m) break;
  }
  return range;
}

FrozenSubmap submap_of_nodes(const NodeRange& nodes, std::size_t origin, const EditedPath& path,
                             const std::function<bool(std::size_t scan)>& ignores) {
  const MapOptions& options = path.map->options;
  const SurfaceOptions surfaces{.range_max_m = options.front_end.range_max_m,
                                .points_max = options.front_end.points_max};
  const Pose2 submap_T_local = path.keys[origin].local_T_robot.inverse();
  Submap submap(options.submap);
  BeamTable beams;
  for (std::size_t node = nodes.first; node <= nodes.last; ++node) {
    const MappedScan& mapped = *path.key_scans[node];
    if (ignores && ignores(mapped.index)) continue;
    submap.insert(
        surface_points(mapped.scan, mapped.robot_T_lidar, sweep_velocity(mapped), surfaces, beams),
        mapped.scan, mapped.robot_T_lidar, submap_T_local * mapped.local_T_robot, beams);
  }
  return submap.freeze();
}

std::optional<LoopClosure> register_places(const HandCandidate& candidate, const EditedPath& path,
                                           const std::function<bool(std::size_t scan)>& ignores) {
  const FrozenSubmap older = submap_of_nodes(candidate.from_nodes, candidate.from, path, ignores);
  const FrozenSubmap newer = submap_of_nodes(candidate.to_nodes, candidate.to, path, ignores);
  const LoopCandidate window{.older_T_newer = candidate.from_T_to,
                             .half_xy_m = candidate.half_xy_m,
                             .half_yaw_rad = candidate.half_yaw_rad};
  const MapOptions& options = path.map->options;
  const auto verified = verify(window, older, newer, options.loop, options.submap, options.match);
  if (!verified) return {};
  LoopClosure closure = verified->closure;
  closure.from = NodeId{static_cast<int>(candidate.from)};
  closure.to = NodeId{static_cast<int>(candidate.to)};
  closure.from_submap = path.submap_of(candidate.from);
  closure.to_submap = path.submap_of(candidate.to);
  return closure;
}

}  // namespace loopstone
