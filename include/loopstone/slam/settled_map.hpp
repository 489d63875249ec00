#pragma once

#include <cstddef>
#include <deque>
#include <vector>

#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/slam/key_chain.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/tracked_pose.hpp"

namespace loopstone {

/// The graph of a map and what came of its loops: all that an edit changes before the map is drawn.
struct SettledGraph {
  PoseGraph graph{};  ///< of all key scans; its edges: the path, then closures that stand. Solved
  std::vector<LoopClosure> closures{};  ///< nodes are those of the graph
};

/// A run whose loops are closed and whose graph is solved: what its last steps (adjustment to
/// surfaces, calibration, drawing, judgement) need, and nothing that waits for more scans.
struct SettledMap {
  RobotModel robot{};
  MapOptions options{};
  KeyChain chain{0.0};  ///< key scans and the scans that the map is drawn from
  SettledGraph settled{};
  std::deque<TrackedPose> track{};  ///< every scan
  /// What was counted on the way: statistics, episodes of the sensors, breaks and drives as they
  /// were met, without what closures tell of them.
  MapResult counted{};
  bool has_gyro = false;
};

}  // namespace loopstone
