#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/slam/key_scan.hpp"
#include "loopstone/slam/path_break.hpp"

namespace loopstone {

/// From the drifting frame of the front end to the map, all along the path. Scans between two nodes
/// share the correction of both, blended by time; where the path breaks between them, by the time
/// of the break: what was seen before it lies with the one before, what was seen after it with the
/// next.
class DriftCorrection {
 public:
  /// \param map_T_key  solved pose of each key scan
  /// \param breaks     in order of time
  DriftCorrection(std::vector<KeyScan> keys, std::span<const Pose2> map_T_key,
                  std::span<const PathBreak> breaks = {});

  /// map_T_local for the scan with that place among all scans.
  [[nodiscard]] Pose2 at(std::size_t scan, Stamp stamp, const Pose2& local_T_robot) const;

 private:
  struct Change {
    Stamp from;
    Stamp to;
  };

  std::vector<KeyScan> keys_;
  std::vector<Pose2> map_T_local_{};  ///< at each key scan
  /// While the correction changes from that of the key scan before to each one's own.
  std::vector<Change> changes_{};
};

}  // namespace loopstone
