#include "loopstone/slam/map_snapshot.hpp"

namespace loopstone {

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
