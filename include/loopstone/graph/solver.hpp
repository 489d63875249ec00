#pragma once

#include <Eigen/Core>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/base/robust_kernel.hpp"
#include "loopstone/base/stop_question.hpp"
#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

enum class DescentMethod {
  kGaussNewton,  ///< undamped steps while they help, damped ones when they do not
  kLevenbergMarquardt,
  kDogleg,
};

constexpr auto words_of(DescentMethod /*any*/) {
  using enum DescentMethod;
  return std::array{Word{kGaussNewton, "gauss_newton"},
                    Word{kLevenbergMarquardt, "levenberg_marquardt"}, Word{kDogleg, "dogleg"}};
}

struct SolverOptions {
  DescentMethod method = DescentMethod::kGaussNewton;
  int max_iterations = 100;
  double relative_tolerance = 1e-7;
  RobustKernel robust_kernel = RobustKernel::kNone;
  double robust_width = 1.0;
  bool robust_everywhere = false;
};

template <typename Visitor>
void visit_options(SolverOptions& options, Visitor&& visit) {
  visit("method", options.method, "how steps are found");
  visit("max_iterations", options.max_iterations, Range{1, 10000}, "stop after so many steps");
  visit("relative_tolerance", options.relative_tolerance, Range{0.0, 0.1},
        "stop when less than this share of the cost is left to gain");
  visit("robust_kernel", options.robust_kernel,
        "how edges that disagree with the rest are softened");
  visit("robust_width", options.robust_width, Range{1e-3, 1e6},
        "standard deviations up to which an edge counts in full");
  visit("robust_everywhere", options.robust_everywhere,
        "soften every edge, not just the loop closures");
}

enum class SolveStatus {
  kConverged,
  kNotConverged,      ///< the iterations ran out; the poses are the best found
  kNumericalFailure,  ///< the normal equations could not be solved; the poses are the best found
  /// several components without a prior or fixed pose: each is solved, but where they lie to one
  /// another is unknown
  kDisconnected,
};

constexpr auto words_of(SolveStatus /*any*/) {
  using enum SolveStatus;
  return std::array{Word{kConverged, "converged"}, Word{kNotConverged, "not_converged"},
                    Word{kNumericalFailure, "numerical_failure"},
                    Word{kDisconnected, "disconnected"}};
}

struct SolveResult {
  std::vector<Pose2> poses;
  std::vector<Eigen::Vector2d> landmarks;
  double cost_initial = 0.0;         ///< sum e^T information e at the start
  double cost = 0.0;                 ///< the same at the poses; no kernel in it
  double robust_cost_initial = 0.0;  ///< what was minimised: the sum after the kernel
  double robust_cost = 0.0;
  int iterations = 0;  ///< steps tried
  SolveStatus status = SolveStatus::kNotConverged;
  int components = 0;                ///< connected parts of the graph
  std::vector<double> edge_weights;  ///< [0, 1] that the kernel gave to each edge
  std::vector<double> prior_weights;
  std::vector<double> landmark_weights;  ///< of the landmark edges
};

/// Poses and landmarks that minimise the sum of (robust) e^T information e, from where the graph
/// has them. The gauge is that of PoseGraph.
///
/// Gauss-Newton lets the cost rise for a few steps before it turns to Levenberg-Marquardt, since
/// full steps often lead through a rise to the optimum; the poses returned are always the best
/// found. What is left to gain is what a step promises, or what the next one would, going by how
/// the promises of undamped steps shrink.
///
/// \param stop  asked before each step; true ends it at the best poses found, kNotConverged
/// Throws UsageError as check_graph does. Graphs without poses or edges are solved as they are.
/// Cost: per step, one multifrontal Cholesky factorisation with 3x3 blocks in a fill-reducing
/// order. Deterministic.
/// Source: Grisetti et al. 2010, "A tutorial on graph-based SLAM"; damping of Nielsen 1999; dogleg
/// of Powell 1970.
[[nodiscard]] SolveResult optimize(const PoseGraph& graph, const SolverOptions& options = {},
                                   const StopQuestion& stop = {});

}  // namespace loopstone
