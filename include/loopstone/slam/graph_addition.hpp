#pragma once

#include <functional>
#include <span>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/sensor/laser_scan.hpp"

namespace loopstone {

/// A key scan as whoever adds to the graph gets to see it.
struct KeyView {
  const LaserScan* scan = nullptr;
  Pose2 robot_T_lidar{};
  Tangent2 velocity = Tangent2::Zero();  ///< of the robot, its own frame [m/s, m/s, rad/s]
};

/// Brings into the graph what else was seen from the key scans, such as landmarks: asked once, when
/// all loops are closed and the graph is solved. It may add landmarks, edges and priors and move
/// the poses to what they say; the poses stay as many as they are. What follows (adjustment to
/// surfaces, drawing, judgement) takes the graph as it leaves it.
/// \param keys  one a pose of the graph, of the same order
using GraphAddition = std::function<void(PoseGraph& graph, std::span<const KeyView> keys)>;

}  // namespace loopstone
