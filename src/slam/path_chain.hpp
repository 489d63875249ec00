#pragma once

#include <Eigen/Core>
#include <vector>

#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

/// The path from node to node, and what it may lose on the way.
struct PathChain {
  std::vector<double> travelled_m{};      ///< at each node
  std::vector<Eigen::Matrix3d> drifts{};  ///< of each edge, map axes
  std::vector<bool> open{};               ///< edges that leave a direction to odometry
  std::vector<Eigen::Vector2d> off{};     ///< each edge from what odometry says, map axes
  double factor = 1.0;                    ///< drifts are wrong by that
  double scale_sigma = 0.0;               ///< so is what is open, all in the same sense
};

/// What an error at a node is at another one, whose way from there is `arm`.
[[nodiscard]] inline Eigen::Matrix3d lever_of(const Eigen::Vector2d& arm) {
  Eigen::Matrix3d lever = Eigen::Matrix3d::Identity();
  lever(0, 2) = -arm.y();
  lever(1, 2) = arm.x();
  return lever;
}

}  // namespace loopstone
