#pragma once

#include <cstddef>
#include <optional>

#include "loopstone/base/stop_question.hpp"
#include "loopstone/graph/certificate.hpp"
#include "loopstone/graph/initial_poses.hpp"
#include "loopstone/graph/outlier_rejection.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/graph/solver.hpp"

namespace loopstone {

/// Edges that a robust solution gives less weight count as set aside.
inline constexpr double kSetAsideBelow = 0.5;

struct GraphOptimisationOptions {
  /// Where to begin. None: at the cheapest start (best_start); with gnc.start_from_odometry at the
  /// odometry, since false closures mislead every other start.
  std::optional<Initialisation> start{};
  /// Whether the graph's own poses mean something; false: they are no candidate for the cheapest
  /// start.
  bool poses_given = true;
  /// Robust kernels are part of it.
  SolverOptions solver{};
  /// Finds out which loop closures are wrong and leaves them out, in place of the solver's kernel.
  std::optional<GncOptions> gnc{};
  /// Proves that the minimum where the solution begins is the global one.
  std::optional<CertificateOptions> certificate{};
  /// Asked before each step: true ends it, and the result is GraphOptimisation::interrupted.
  StopQuestion stop{};

  [[nodiscard]] bool is_robust() const {
    return gnc || solver.robust_kernel != RobustKernel::kNone;
  }
};

/// Wall time of each part [s], and the CPU time of all of them.
struct GraphOptimisationTimes {
  double start_s = 0.0;
  double certify_s = 0.0;
  double solve_s = 0.0;
  double cpu_s = 0.0;

  [[nodiscard]] double wall_s() const { return start_s + certify_s + solve_s; }
};

/// A pose graph solved from scratch.
struct GraphOptimisation {
  GraphStart start{};    ///< where it began
  SolveResult solved{};  ///< cost_initial is that of the start
  /// Of the edges that were kept, when a certificate was asked for.
  std::optional<CertifiedSolution> certified{};
  bool interrupted = false;  ///< nothing here is a solution then
  GraphOptimisationTimes times{};

  /// Steps of the certified minimum and of the solution.
  [[nodiscard]] int iterations() const {
    return solved.iterations + (certified ? certified->iterations : 0);
  }
};

/// Solves a pose graph as a whole: chooses the start, and ends at the minimum of chi2 (or of its
/// robust kernel).
///
/// With a certificate and no robust weights the isotropic objective is minimised first, its minimum
/// is proven to be global, and the solution begins there. With robust weights the solution comes
/// first, since it is what finds out which edges count; what is certified then is the isotropic
/// minimum of the edges that it kept (weight at least kSetAsideBelow), and the certificate says how
/// many it did not: a kernel may well turn down what was right, and then that is proven optimal
/// which is left, a bare chain at worst.
///
/// \param graph  connected, or each part held by a fixed pose or a prior; else status kDisconnected
/// Throws UsageError as check_graph does. Deterministic but for the times.
/// Cost: of best_start, optimize or optimize_gnc, and optimize_certified; docs/benchmarks.md.
[[nodiscard]] GraphOptimisation optimize_graph(const PoseGraph& graph,
                                               const GraphOptimisationOptions& options = {});

/// Edges of less weight than kSetAsideBelow.
[[nodiscard]] std::size_t edges_set_aside(const SolveResult& solved);

}  // namespace loopstone
