#include "loopstone/slam/map_snapshot.hpp"

#include <utility>

namespace loopstone {

SubmapSnapshot snapshot_of(const SubmapRecord& submap, std::size_t index) {
  auto scans = submap.scans.share();
  const Pose2 map_T_local = submap.map_T_submap * scans->front()->local_T_robot.inverse();
  return {.id = {index},
          .state = submap.state,
          .map_T_submap = submap.map_T_submap,
          .map_T_local = map_T_local,
          .scans = std::move(scans)};
}

std::vector<KeyScanSnapshot> MapSnapshot::key_scans() const {
  std::vector<KeyScanSnapshot> keys;
  for (const SubmapSnapshot& submap : submaps) {
    for (const auto& mapped : *submap.scans) {
      if (!mapped->is_key) continue;
      keys.push_back({mapped->scan.stamp, static_cast<std::int64_t>(mapped->index),
                      submap.map_T_local * mapped->local_T_robot});
    }
  }
  return keys;
}

}  // namespace loopstone
