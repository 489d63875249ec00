#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "graph/block_cholesky.hpp"
#include "loopstone/base/robust_kernel.hpp"
#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

/// Which kernel softens which edges.
struct RobustPolicy {
  RobustKernel kernel = RobustKernel::kNone;
  double width = 1.0;
  bool everywhere = false;

  [[nodiscard]] RobustValue of(EdgeKind kind, double chi2) const {
    const bool soft = everywhere || kind == EdgeKind::kLoopClosure;
    return evaluate(soft ? kernel : RobustKernel::kNone, width, chi2);
  }
};

/// The cost at some poses, plain and after the kernel.
struct GraphCosts {
  double plain = 0.0;
  double robust = 0.0;
};

/// H dx = -g of a pose graph: H = sum w J^T information J, g = sum w J^T information e, in an order of the free poses
/// that keeps the Cholesky factor sparse. The pattern is built once; only values change from step to step.
class NormalEquations {
 public:
  /// \param fixed  one flag a pose; the others are free
  NormalEquations(const PoseGraph& graph, const std::vector<bool>& fixed,
                  const RobustPolicy& policy);

  [[nodiscard]] GraphCosts costs(std::span<const Pose2> poses) const;
  [[nodiscard]] std::vector<double> edge_weights(std::span<const Pose2> poses) const;

  /// Sets H and g at the poses.
  void linearise(std::span<const Pose2> poses);

  [[nodiscard]] const BlockMatrix& hessian() const { return hessian_; }
  [[nodiscard]] const std::vector<Eigen::Vector3d>& gradient() const { return gradient_; }
  /// Where a pose stands in H and g; -1 when it is fixed.
  [[nodiscard]] int place_of(std::size_t pose) const { return place_[pose]; }

 private:
  /// An edge with what does not change while solving.
  struct Term {
    std::size_t from;
    std::size_t to;
    int place_from;
    int place_to;
    int below;  ///< its block in hessian_.below; -1 when a pose is fixed
    Pose2 from_T_to;
    Eigen::Matrix3d information;  ///< with axes as the measured pose's parent: Rz information Rz^T
    EdgeKind kind;
  };
  /// Rz e: the error before it is rotated to the measurement's axes.
  [[nodiscard]] Eigen::Vector3d error_of(const Term& term, std::span<const Pose2> poses) const;

  RobustPolicy policy_;
  std::vector<int> place_;
  std::vector<Term> terms_;
  BlockMatrix hessian_;
  std::vector<Eigen::Vector3d> gradient_;
};

}  // namespace loopstone
