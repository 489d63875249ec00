#pragma once

#include <optional>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// What is kept of every scan.
struct TrackedPose {
  Stamp stamp{};
  Pose2 local_T_robot{};
  std::optional<Pose2> odom_T_robot{};  ///< dead reckoning alone

  template <typename Archive>
  void archive(Archive& a) {
    a(stamp, local_T_robot, odom_T_robot);
  }
};

}  // namespace loopstone
