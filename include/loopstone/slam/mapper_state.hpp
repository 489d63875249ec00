#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/odometry/scan_queue.hpp"
#include "loopstone/slam/back_end.hpp"
#include "loopstone/slam/front_end.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/mapped_scan.hpp"
#include "loopstone/slam/odom_frame.hpp"
#include "loopstone/slam/path_break.hpp"
#include "loopstone/slam/tracked_pose.hpp"

namespace loopstone {

/// A mapped scan on its way to the back end.
struct WaitingScan {
  std::shared_ptr<const MappedScan> scan{};
  std::optional<KeyScan> key{};

  template <typename Archive>
  void archive(Archive& a) {
    if constexpr (Archive::kReads) {
      MappedScan read;
      a(read, key);
      scan = std::make_shared<const MappedScan>(std::move(read));
    } else {
      a(*scan, key);
    }
  }
};

/// Everything that the messages so far have led to, as plain data: what a mapper of the same robot
/// and options needs to go on.
struct MapperState {
  /// What the mapper keeps beside its parts.
  struct SoFar {
    std::deque<TrackedPose> track{};
    Pose2 last_mapped{};
    MapStatistics statistics{};
    std::int64_t gyro_scans = 0;  ///< whose heading alone was known
    std::vector<PathBreak> breaks{};
    std::int64_t lost_scans = 0;  ///< the last so many contradicted the map, and were left out
    std::vector<MappedDrive> drives{};  ///< after the first
    bool drive_begins = false;          ///< no scan of the newest was mapped yet
    std::size_t submaps_opened = 0;
    std::size_t submaps_frozen = 0;

    template <typename Archive>
    void archive(Archive& a) {
      a(track, last_mapped, statistics, gyro_scans, breaks, lost_scans, drives, drive_begins,
        submaps_opened, submaps_frozen);
    }
  };
  ScanQueue::State scan_queue{};
  FrontEnd::State front_end{};
  SoFar so_far{};
  OdomFrame::State odom_frame{};
  std::vector<WaitingScan> waiting{};
  BackEnd::State back_end{};

  template <typename Archive>
  void archive(Archive& a) {
    a(scan_queue, front_end, so_far, odom_frame, waiting, back_end);
  }
};

/// Whether a state hangs together: every index lies inside what it points into, whatever comes in
/// order does. For what comes from a file; a mapper asks it before it goes on from a state.
/// \param reach_m  no submap reaches farther than this from its origin
[[nodiscard]] bool is_sound(const MapperState& state, double reach_m);

}  // namespace loopstone
