#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "loopstone/base/robust_kernel.hpp"
#include "loopstone/graph/block_system.hpp"
#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

/// What a pose graph estimates.
struct GraphState {
  std::vector<Pose2> poses{};                ///< map_T_node
  std::vector<Eigen::Vector2d> landmarks{};  ///< in the map frame [m]
};

/// The normal equations H dx = -g of a pose graph, for solvers that add terms of their own to it: H
/// = sum w J^T Omega J and g = sum w J^T Omega e over its edges, priors and landmark edges, w being
/// what a kernel gives to loop closures.
///
/// Free poses and landmarks have places in H and g, in an order that keeps the Cholesky factor
/// sparse. The coordinates are x, y, yaw, added to the pose's; a landmark takes a block as a pose
/// does, its third coordinate idle. The pattern is built once. Not thread-safe. Deterministic.
class LinearisedGraph {
 public:
  /// \param graph   what it measures; the gauge is that of PoseGraph
  /// \param kernel  softens the loop closures, at so many standard deviations
  /// Throws UsageError as check_graph does.
  explicit LinearisedGraph(const PoseGraph& graph, RobustKernel kernel = RobustKernel::kNone,
                           double kernel_width = 1.0);
  ~LinearisedGraph();
  LinearisedGraph(LinearisedGraph&&) noexcept;
  LinearisedGraph& operator=(LinearisedGraph&&) noexcept;

  /// Sets H and g; returns the sum of e^T Omega e after the kernel. Cost: O(measurements).
  double linearise(const GraphState& state);

  [[nodiscard]] const BlockMatrix& hessian() const;
  [[nodiscard]] const std::vector<Eigen::Vector3d>& gradient() const;
  /// Where a pose stands in H and g; -1 when it is held.
  [[nodiscard]] int place_of(NodeId node) const;
  /// The same of a landmark; -1 when no pose sees it.
  [[nodiscard]] int place_of(LandmarkId landmark) const;
  /// The state after a step dx.
  [[nodiscard]] GraphState moved(const GraphState& from,
                                 std::span<const Eigen::Vector3d> step) const;

 private:
  struct Equations;
  std::unique_ptr<Equations> equations_;
};

}  // namespace loopstone
