#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/base/robust_kernel.hpp"
#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

struct SolverOptions {
  int max_iterations = 100;
  /// Stop when a step promises to lower the cost by less than this share.
  double relative_tolerance = 1e-8;
  std::string robust_kernel = "none";
  /// In standard deviations of an edge.
  double robust_width = 1.0;
  /// Whether the kernel softens every edge, not just the loop closures.
  bool robust_everywhere = false;
};

template <typename Visitor>
void visit_options(SolverOptions& options, Visitor&& visit) {
  visit("max_iterations", options.max_iterations, Range{1, 10000}, "stop after so many steps");
  visit("relative_tolerance", options.relative_tolerance, Range{0.0, 0.1},
        "stop when a step promises to lower the cost by less than this share");
  visit("robust_kernel", options.robust_kernel,
        OneOf{{"none", "huber", "cauchy", "geman_mcclure", "tukey"}},
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
  kDisconnected,  ///< several components: each is solved, but where they lie to one another is unknown
};

[[nodiscard]] std::string_view to_string(SolveStatus status);

struct SolveResult {
  std::vector<Pose2> poses;
  double cost_initial = 0.0;         ///< sum e^T information e at the start
  double cost = 0.0;                 ///< the same at the poses; no kernel in it
  double robust_cost_initial = 0.0;  ///< what was minimised: the sum after the kernel
  double robust_cost = 0.0;
  int iterations = 0;  ///< steps tried
  SolveStatus status = SolveStatus::kNotConverged;
  int components = 0;                ///< connected parts of the graph
  std::vector<double> edge_weights;  ///< (0, 1] that the kernel gave to each edge
};

/// Poses that minimise the sum of (robust) e^T information e, from the graph's poses: Gauss-Newton; when a step does
/// not lower the cost, Levenberg-Marquardt until one does. The first pose of each component is held fixed.
///
/// Throws UsageError as check_graph does, and for an unknown kernel. Graphs without poses or edges are solved as they are.
/// Cost: per step, one sparse Cholesky factorisation with 3x3 blocks in a fill-reducing order. Deterministic.
/// Source: Grisetti et al. 2010, "A tutorial on graph-based SLAM"; damping of Nielsen 1999.
[[nodiscard]] SolveResult optimize(const PoseGraph& graph, const SolverOptions& options = {});

}  // namespace loopstone
