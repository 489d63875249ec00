#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/slam/key_scan.hpp"

namespace loopstone {

/// From the drifting frame of the front end to the map, all along the path. Scans between two nodes
/// share the correction of both, blended by time.
class DriftCorrection {
 public:
  /// \param map_T_key  solved pose of each key scan
  DriftCorrection(std::vector<KeyScan> keys, std::span<const Pose2> map_T_key);

  /// map_T_local for the scan with that place among all scans.
  [[nodiscard]] Pose2 at(std::size_t scan, Stamp stamp, const Pose2& local_T_robot) const;

 private:
  std::vector<KeyScan> keys_;
  std::vector<Pose2> map_T_local_{};  ///< at each key scan
};

}  // namespace loopstone
