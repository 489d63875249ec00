#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/odometry/odometry_check.hpp"
#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/slam/laser_check.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/path_break.hpp"

namespace loopstone {

/// A scan that maps are drawn from.
struct MappedScan {
  LaserScan scan{};
  std::size_t index = 0;  ///< among all scans
  Pose2 robot_T_lidar{};
  Pose2 local_T_robot{};      ///< where the front end put it; local: smooth, drifts
  Pose2 local_T_robot_end{};  ///< at the end of its sweep
  bool is_key = false;

  template <typename Archive>
  void archive(Archive& a) {
    a(scan, index, robot_T_lidar, local_T_robot, local_T_robot_end, is_key);
  }
};

/// Scans in order. They never change; holders share them.
using MappedScans = std::vector<std::shared_ptr<const MappedScan>>;

enum class SubmapState {
  kOpen,     ///< scans are still added
  kFrozen,   ///< full
  kDropped,  ///< older ones saw all of it: nothing is compared with it, its scans are thinned
};

/// A submap, and the scans from its beginning to that of the next one.
struct SubmapSnapshot {
  SubmapId id{};
  SubmapState state = SubmapState::kOpen;
  Pose2 map_T_submap{};  ///< of its first key scan
  Pose2 map_T_local{};   ///< puts its scans on the map
  std::shared_ptr<const MappedScans> scans{};
};

struct KeyScanSnapshot {
  Stamp stamp{};
  std::int64_t scan = 0;  ///< its number among all scans
  Pose2 map_T_robot{};
};

/// The map as it is at one moment, all of a piece. Copies share the scans: some hundred bytes a
/// submap.
struct MapSnapshot {
  std::vector<SubmapSnapshot> submaps{};  ///< by their ids
  std::vector<LoopClosure> closures{};    ///< nodes are submaps
  std::vector<OdometryEpisode> odometry_episodes{};
  std::vector<LaserEpisode> laser_episodes{};
  std::vector<PathBreak> breaks{};
  std::vector<std::string> warnings{};  ///< of sensors, in plain words

  /// Each key scan that is kept, in order. Within a submap they are as the front end had them.
  [[nodiscard]] std::vector<KeyScanSnapshot> key_scans() const;
};

}  // namespace loopstone
