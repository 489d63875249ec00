#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// A scan that is a node of the graph.
struct KeyScan {
  Stamp stamp{};
  Pose2 local_T_robot{};  ///< where the front end put it
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Zero();  ///< of that match, (x, y, yaw), local frame
  std::size_t scan = 0;         ///< its place among all scans
  bool starts_submap = false;
  bool starts_drive = false;  ///< nothing is known of the motion from the key scan before
  /// Of the motion from the key scan before, where the laser did not hold it: (x, y, yaw), local
  /// frame.
  std::optional<Eigen::Matrix3d> across{};

  template <typename Archive>
  void archive(Archive& a) {
    a(stamp, local_T_robot, covariance, scan, starts_submap, starts_drive, across);
  }
};

}  // namespace loopstone
