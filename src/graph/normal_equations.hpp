#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "graph/block_cholesky.hpp"
#include "loopstone/base/robust_kernel.hpp"
#include "loopstone/graph/linearised_graph.hpp"
#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

/// Which kernel softens which edges.
struct RobustPolicy {
  RobustKernel kernel = RobustKernel::kNone;
  double width = 1.0;
  bool everywhere = false;

  [[nodiscard]] RobustValue of(bool closure, double chi2) const {
    if (kernel == RobustKernel::kNone || !(everywhere || closure)) return {chi2, 1.0};
    return evaluate(kernel, width, chi2);
  }
};

/// The cost at some poses, plain and after the kernel.
struct GraphCosts {
  double plain = 0.0;
  double robust = 0.0;
};

/// The weights that the kernel gives to each measurement.
struct GraphWeights {
  std::vector<double> edges{};
  std::vector<double> priors{};
  std::vector<double> landmark_edges{};
};

/// H dx = -g of a pose graph: H = sum w J^T information J, g = sum w J^T information e, in an order
/// of the free poses and landmarks that keeps the Cholesky factor sparse. The pattern is built
/// once; only values change from step to step. A landmark takes a block of 3x3 as a pose does; its
/// third coordinate is idle (1 on the diagonal).
class NormalEquations {
 public:
  /// \param fixed  one flag a pose; the others are free, as are landmarks that some pose sees
  NormalEquations(const PoseGraph& graph, const std::vector<bool>& fixed,
                  const RobustPolicy& policy);

  [[nodiscard]] GraphCosts costs(const GraphState& state);
  [[nodiscard]] GraphWeights weights(const GraphState& state);

  /// Sets H and g at the state, whose costs it returns.
  GraphCosts linearise(const GraphState& state);

  /// Factors on the information of the edges, beside the kernel's; all 1 at first.
  void set_edge_scales(std::span<const double> scales);

  [[nodiscard]] const BlockMatrix& hessian() const { return hessian_; }
  [[nodiscard]] const std::vector<Eigen::Vector3d>& gradient() const { return gradient_; }
  /// Where a pose or landmark stands in H and g; -1 when it is fixed.
  [[nodiscard]] int place_of(std::size_t pose) const { return place_[pose]; }
  [[nodiscard]] int place_of_landmark(std::size_t landmark) const {
    return place_[pose_count_ + landmark];
  }

 private:
  /// A measurement between a pose and a pose or landmark, with what does not change while solving.
  struct Term {
    int from = 0;
    int to = 0;  ///< pose, or landmark
    int place_from = -1;
    int place_to = -1;
    int below = -1;  ///< its block in hessian_.below; -1 when an end is fixed
    bool closure = false;
    double x = 0.0;  ///< measured
    double y = 0.0;
    double yaw = 0.0;
    double scale = 1.0;
    /// With axes as the measured pose's parent, Rz information Rz^T: xx, xy, xt, yy, yt, tt.
    std::array<double, 6> information{};
  };
  struct PriorTerm {
    int node = 0;
    int place = -1;
    Pose2 map_T_node;
    Eigen::Matrix3d information;  ///< with axes as the map
  };
  struct Error {
    double x = 0.0;
    double y = 0.0;
    double yaw = 0.0;
    double wx = 0.0;  ///< information * error
    double wy = 0.0;
    double wyaw = 0.0;
    double chi2 = 0.0;
  };
  void build_pattern(const PoseGraph& graph, const std::vector<bool>& fixed);
  void find_sines(const std::vector<Pose2>& poses);
  [[nodiscard]] Error error_of(const Term& term, const std::vector<Pose2>& poses) const;
  [[nodiscard]] Error landmark_error_of(const Term& term, const GraphState& state) const;
  void add(const Term& term, const Error& error, double weight, double dx, double dy);
  void add_prior(const PriorTerm& term, const Eigen::Vector3d& error, double weight);
  /// Calls visit_edge(i, term, error), visit_landmark_edge(i, term, error), visit_prior(i, term,
  /// error, chi2).
  template <typename Edge, typename Landmark, typename Prior>
  void for_each(const GraphState& state, Edge&& visit_edge, Landmark&& visit_landmark_edge,
                Prior&& visit_prior);

  RobustPolicy policy_;
  std::size_t pose_count_ = 0;
  std::vector<int> place_;
  std::vector<Term> terms_;
  std::vector<Term> landmark_terms_;
  std::vector<PriorTerm> prior_terms_;
  BlockMatrix hessian_;
  std::vector<Eigen::Vector3d> gradient_;
  std::vector<std::pair<double, double>> cos_sin_;  ///< of the poses' yaw
};

}  // namespace loopstone
