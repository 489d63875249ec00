#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/odometry/odometry_check.hpp"
#include "loopstone/slam/laser_check.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/mapped_scan.hpp"
#include "loopstone/slam/path_break.hpp"
#include "loopstone/slam/submap_record.hpp"

namespace loopstone {

/// A submap, and the scans from its beginning to that of the next one.
struct SubmapSnapshot {
  SubmapId id{};
  SubmapState state = SubmapState::kOpen;
  Pose2 map_T_submap{};  ///< of its first key scan
  Pose2 map_T_local{};   ///< puts its scans on the map
  std::shared_ptr<const MappedScans> scans{};
};

/// \param index  its place among the submaps. It must have scans.
[[nodiscard]] SubmapSnapshot snapshot_of(const SubmapRecord& submap, std::size_t index);

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
