#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/odometry/odometry_check.hpp"
#include "loopstone/slam/laser_check.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/path_break.hpp"
#include "loopstone/slam/tracking_status.hpp"

namespace loopstone {

/// A submap begins with this scan.
struct SubmapOpened {
  SubmapId id{};
};
/// A submap is full: its shape will not change any more, its place may.
struct SubmapFrozen {
  SubmapId id{};
};
/// Older submaps saw all that it saw: its scans are thinned, nothing is compared with it any more.
struct SubmapDropped {
  SubmapId id{};
};
/// A closure was found (waiting or rejected), came to stand, or was revoked.
struct ClosureChanged {
  LoopClosure closure{};
};
/// The pose graph was solved.
struct GraphSolved {
  std::size_t submaps = 0;    ///< nodes
  std::size_t closures = 0;   ///< that stand
  double mean_shift_m = 0.0;  ///< how far submaps moved
  double largest_shift_m = 0.0;
  double largest_turn_rad = 0.0;
};
/// Odometry, or a part of it, was found wrong (`over` false), or has become right again.
struct OdometryFaultChanged {
  OdometryEpisode episode{};
};
/// The laser is blocked or frozen, or it is no more (`over`).
struct LaserFaultChanged {
  LaserEpisode episode{};
  bool over = false;
};
/// The laser holds the pose again after it did not for a while.
struct PathBroken {
  PathBreak gap{};
};

using MapEvent = std::variant<SubmapOpened, SubmapFrozen, SubmapDropped, ClosureChanged,
                              GraphSolved, OdometryFaultChanged, LaserFaultChanged, PathBroken>;

/// Where the robot is at a scan, and what happened since the scan before.
///
/// Frames as REP-105 has them: `odom` goes on smoothly whatever happens and drifts; `map` is where
/// closed loops put the robot, so map_T_odom moves when they close, or when a lost robot is found.
struct MapUpdate {
  Stamp stamp{};
  std::int64_t scan = 0;  ///< its number among all scans, from 0
  Pose2 odom_T_robot{};
  Pose2 map_T_odom{};
  /// Of map_T_robot() against what is around it, (x, y, yaw), map axes [m^2, m rad, rad^2]. What
  /// the path has drifted since the place was first seen is not in it.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  TrackingStatus status = TrackingStatus::kTracked;
  /// kDegenerate: the direction that the laser leaves open, map axes [rad], in [0, pi).
  std::optional<double> open_direction_rad{};
  std::optional<std::size_t> key_scan{};  ///< its number among the key scans, if it is one
  /// The front end's events are those of this scan. Those of loop closing come with the first
  /// update after they happened: which one that is depends on how fast the machine is.
  std::vector<MapEvent> events{};
  std::int64_t missed = 0;  ///< updates given up before this one, because nobody took them

  [[nodiscard]] Pose2 map_T_robot() const { return map_T_odom * odom_T_robot; }
};

}  // namespace loopstone
