#pragma once

#include <cstddef>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/base/stop_question.hpp"
#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

/// What is certified is the isotropic objective of SE-Sync, which is not chi2:
///
///   F = sum over edges of kappa |R_to - R_from R_edge|_F^2 + tau |t_to - t_from - R_from
///   t_edge|^2, kappa = I33 and tau = 2 / tr((I_tt)^-1) of the edge's information (I_tt: of x and
///   y),
///
/// with priors as edges from the map, and landmark edges without their rotation term.
/// Rosen, Carlone, Bandeira and Leonard 2019, "SE-Sync", problem 1 and its reference
/// implementation.
struct CertificateOptions {
  double relative_gap = 1e-7;
  int max_iterations = 100;
  int max_rank = 4;
};

template <typename Visitor>
void visit_options(CertificateOptions& options, Visitor&& visit) {
  visit("relative_gap", options.relative_gap, Range{1e-12, 1.0},
        "certified means that no solution is cheaper by more than this share of the cost");
  visit("max_iterations", options.max_iterations, Range{1, 10000},
        "steps of one descent to a minimum");
  visit("max_rank", options.max_rank, Range{1, 10},
        "of the relaxation that leads out of a local minimum, in complex numbers; 1: no way out");
}

enum class CertificateStatus {
  kCertified,     ///< the global optimum, to within the tolerance
  kNotOptimal,    ///< a better solution exists near: the smallest eigenvalue is negative
  kGapOpen,       ///< the relaxation is solved, and its bound is lower than the best solution found
  kNotConverged,  ///< the iterations ran out before anything could be said
  kNumericalFailure,  ///< a factorisation failed beyond rounding
  kUnsupported,  ///< more than one pose of a component is held, so the objective is another one
};

constexpr auto words_of(CertificateStatus /*any*/) {
  using enum CertificateStatus;
  return std::array{Word{kCertified, "certified"},
                    Word{kNotOptimal, "not_optimal"},
                    Word{kGapOpen, "gap_open"},
                    Word{kNotConverged, "not_converged"},
                    Word{kNumericalFailure, "numerical_failure"},
                    Word{kUnsupported, "unsupported"}};
}

struct Certificate {
  CertificateStatus status = CertificateStatus::kNotConverged;
  double cost = 0.0;  ///< F at the poses
  /// Of the dual certificate matrix S = Q - Lambda, as found by Lanczos; at an optimum 0 to
  /// rounding.
  double min_eigenvalue = 0.0;
  /// Proven by a Cholesky factorisation: the smallest eigenvalue is above minus this.
  double eigenvalue_tolerance = 0.0;
  double lower_bound = 0.0;     ///< no solution costs less; -infinity when nothing is known
  double optimality_gap = 0.0;  ///< cost - lower_bound
  std::size_t edges = 0;        ///< between poses, of the problem that it is about
  /// Edges that a robust solution turned down before (optimize_graph): nothing is said of them, and
  /// of whether they were right.
  std::size_t edges_set_aside = 0;
  std::size_t closures_set_aside = 0;  ///< of these, loop closures

  [[nodiscard]] bool certified() const { return status == CertificateStatus::kCertified; }
  /// It is about every edge of the graph.
  [[nodiscard]] bool is_of_whole_graph() const { return edges_set_aside == 0; }
};

/// Whether the graph's poses are a global optimum of F, up to a motion of each component.
/// Throws UsageError as check_graph does. Cost: one or two sparse factorisations, a few more when
/// the answer is no.
[[nodiscard]] Certificate verify_optimality(const PoseGraph& graph,
                                            const CertificateOptions& options = {});

struct CertifiedSolution {
  std::vector<Pose2> poses{};
  std::vector<Eigen::Vector2d> landmarks{};
  Certificate certificate{};
  double cost_initial = 0.0;  ///< F at the graph's poses
  int iterations = 0;         ///< Newton steps of all descents
  int rank = 1;     ///< of the relaxation that was climbed; 1: the first minimum was the optimum
  int escapes = 0;  ///< local minima that were left behind
};

/// Minimises F from the graph's poses, proves the minimum global, and when it is not, leaves it
/// along the direction of negative curvature in a relaxation of higher rank (Riemannian staircase:
/// Boumal 2015; Rosen et al. 2019, section 5.2), comes back to the plane and tries again. Held
/// poses and each component's first one stay where they are.
/// \param stop  asked before each step; true ends it, at the latest with kNotConverged after what a
///              proof takes
/// Throws UsageError as check_graph does. Deterministic.
[[nodiscard]] CertifiedSolution optimize_certified(const PoseGraph& graph,
                                                   const CertificateOptions& options = {},
                                                   const StopQuestion& stop = {});

/// F at the graph's poses.
[[nodiscard]] double isotropic_cost(const PoseGraph& graph);

}  // namespace loopstone
