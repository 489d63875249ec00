#pragma once

#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/localization/localization_scan.hpp"

namespace loopstone {

/// What each of a robot's lasers saw last, where it is from the robot now. Lasers that look
/// different ways tell more of a place together than in turn.
class OtherLasers {
 public:
  /// The robot moved, from_T_to.
  void move(const Pose2& motion);
  /// Takes the place of what this laser saw before.
  void remember(int lidar, Stamp stamp, const SeenByLaser& view);
  /// What lasers other than this one saw a moment before a scan, in the robot's frame at the scan.
  [[nodiscard]] std::vector<SeenByLaser> beside(int lidar, Stamp stamp) const;

 private:
  struct Seen {
    int lidar = 0;
    Stamp stamp{};
    Pose2 now_T_then{};
    SeenByLaser view{};
  };

  std::vector<Seen> seen_{};
};

/// Whether a laser tells anything of where the robot is: it has returns, and not all that it sees
/// is so near that it covers the laser.
[[nodiscard]] bool sees(const SeenByLaser& view);

/// Whether one of its lasers does.
[[nodiscard]] bool shows_place(const LocalizationScan& scan);

}  // namespace loopstone
