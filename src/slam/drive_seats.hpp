#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/slam/drive_record.hpp"
#include "loopstone/slam/loop_closer.hpp"

namespace loopstone {

/// Where a drive lies among others that it is counted with: its first submap, scan and piece of the
/// path, what is added to its stamps, and where it is taken to begin.
struct DriveSeat {
  std::size_t submap = 0;
  std::size_t scan = 0;
  std::size_t piece = 0;
  Duration clock_shift{};
  Pose2 local_T_drive{};
  PathBreak before{};  ///< of the path; nothing tells where the drive begins
};

/// One after the other, in order.
[[nodiscard]] std::vector<DriveSeat> seats_of(
    std::span<const std::shared_ptr<const DriveRecord>> drives);

/// Key scans, mapped scans and submaps of a drive as its seat has them: without closures.
[[nodiscard]] KeyChain::State seated(const KeyChain::State& chain, const DriveSeat& seat);
/// Likewise.
[[nodiscard]] PathBreak seated(PathBreak gap, const DriveSeat& seat);
[[nodiscard]] TrackedPose seated(TrackedPose pose, const DriveSeat& seat);

}  // namespace loopstone
