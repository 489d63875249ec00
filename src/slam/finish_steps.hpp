#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/slam/graph_addition.hpp"
#include "loopstone/slam/key_chain.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/settled_map.hpp"

// From a settled map to its result, by steps that can be taken alone: a run takes them all, an edit
// looks at the first ones.

namespace loopstone {

/// What differs between a run that ends and a map that is edited. Empty functions: nothing.
struct FinishCalls {
  std::function<bool(int stage)> goes_on_to{};  ///< before each stage; false: it is cancelled
  GraphAddition addition{};
  std::function<bool(std::size_t scan)> ignores{};  ///< scans that are not used any more
  /// Once poses are final: new_T_map, of the frame in which the map is told.
  std::function<Pose2(const MapResult&)> frame{};
  /// Draws the map in place of build_occupancy_map().
  std::function<OccupancyMap(std::span<const PosedScan>)> draw{};
  std::function<void(MapResult&)> touch_up{};  ///< the map was drawn
  std::function<void()> track_is_told{};       ///< the settled map's track is not needed any more
};
inline constexpr int kFinishStages = 5;

/// Graph and closures, what was counted, and what both tell of breaks and drives.
[[nodiscard]] MapResult begin_result(const SettledMap& map, SettledGraph settled);

/// Moves all key scans onto the surfaces that they share.
void adjust(const SettledMap& map, const FinishCalls& calls, Threads threads, MapResult& result);

/// How the sensors sit, from the path as the front end knows it.
void find_calibration(const KeyChain& chain, const std::deque<TrackedPose>& track,
                      const RobotModel& robot, const MapOptions& options, MapResult& result);

/// All key scans where the finished map has them, without drawing it: adjusted, by the mount that
/// the drive tells. The result's graph has their poses.
[[nodiscard]] MapResult place_keys(const SettledMap& map, SettledGraph settled,
                                   const FinishCalls& calls, Threads threads);

/// All steps.
[[nodiscard]] MapResult finish_settled(const SettledMap& map, SettledGraph settled,
                                       const FinishCalls& calls, Threads threads);

}  // namespace loopstone
