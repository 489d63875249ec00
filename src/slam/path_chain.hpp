#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"

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

/// Which way the path leads at an edge, over a metre of it or so: a step by itself may lead
/// anywhere where the robot stood, or where nothing is known of it. Map axes, unit; zero on the
/// spot.
[[nodiscard]] Eigen::Vector2d way_at(std::span<const Pose2> poses, std::size_t edge);

/// The chain, were edges that leave a direction to odometry as long as they are: what they lose
/// beside the way and in heading is left.
[[nodiscard]] PathChain with_open_ways_known(std::span<const Pose2> poses, PathChain chain);

}  // namespace loopstone
