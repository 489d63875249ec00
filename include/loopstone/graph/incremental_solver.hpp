#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/graph/solver.hpp"

namespace loopstone {

struct IncrementalOptions {
  double relinearise_m = 0.1;
  double relinearise_rad = 0.02;
  int relinearise_every = 2;
  double negligible_change = 1e-3;
  int poses_at_once = 1000;
  double wait_chi2 = 3.0;
  int wait_updates = 10;
  RobustKernel robust_kernel = RobustKernel::kNone;
  double robust_width = 1.0;
};

template <typename Visitor>
void visit_options(IncrementalOptions& options, Visitor&& visit) {
  visit("relinearise_m", options.relinearise_m, Range{0.0, 10.0},
        "edges of poses that moved farther are linearised anew");
  visit("relinearise_rad", options.relinearise_rad, Range{0.0, 3.2},
        "edges of poses that turned more are linearised anew");
  visit("relinearise_every", options.relinearise_every, Range{1, 1000},
        "eliminations between two looks for moved poses");
  visit("negligible_change", options.negligible_change, Range{0.0, 1.0},
        "smaller changes are not passed on to poses farther away");
  visit("poses_at_once", options.poses_at_once, Range{1, 1000000000},
        "poses farther away to which one update passes its changes on");
  visit("wait_chi2", options.wait_chi2, Range{0.0, 1e9},
        "closures wait while all that wait cost less than this");
  visit("wait_updates", options.wait_updates, Range{1, 1000},
        "and for fewer updates than this; 1: none waits");
  visit("robust_kernel", options.robust_kernel,
        "how loop closures that disagree with the rest are softened");
  visit("robust_width", options.robust_width, Range{1e-3, 1e6},
        "standard deviations up to which a loop closure counts in full");
}

/// What an update did.
struct IncrementalUpdate {
  bool waits = false;  ///< the edges agree with what is known and are brought in by a later update
  std::size_t poses_eliminated = 0;  ///< again or for the first time
  std::size_t poses_relinearised = 0;
  std::size_t poses_changed = 0;
};

/// A pose graph that grows while it is solved. Keeps the factor of its normal equations; new edges
/// change only what lies between their poses and the root of the elimination tree, and only that is
/// ordered and eliminated again.
///
/// What is approximate between two calls of solve(): edges stay linearised where their poses were
/// until these have moved by the options' bounds, kernels keep the weights of that moment, small
/// changes are not passed on, and large ones arrive at far poses some updates later. A pose that
/// was appended waits for the next loop closure: until then its one edge fits exactly and moves
/// nothing, so nothing is lost. A closure that agrees with what is known waits for others, since
/// one elimination for all of them costs little more than one for each; what its edges cost at the
/// present poses is the most that is lost by that. The newest pose does not wait: it lies where its
/// edges want it, the others held.
///
/// The first pose is held fixed. Not thread-safe. Deterministic.
/// Source: Kaess et al. 2012, "iSAM2: Incremental smoothing and mapping using the Bayes tree", with
/// a multifrontal Cholesky factorisation in place of QR.
class IncrementalSolver {
 public:
  /// Starts with one pose.
  explicit IncrementalSolver(const Pose2& first, const IncrementalOptions& options = {});
  /// Starts from a graph, solved to convergence. Throws UsageError unless it is connected and made
  /// of poses and edges alone.
  explicit IncrementalSolver(const PoseGraph& graph, const IncrementalOptions& options = {});
  ~IncrementalSolver();
  IncrementalSolver(IncrementalSolver&&) noexcept;
  IncrementalSolver& operator=(IncrementalSolver&&) noexcept;

  /// Appends a pose where the edge from an existing pose puts it. Throws UsageError for a pose that
  /// does not exist or a measurement that check_graph would refuse. Cost: constant.
  NodeId append(NodeId from, const Pose2& from_T_new, const Eigen::Matrix3d& information,
                EdgeKind kind = EdgeKind::kOdometry);

  /// Adds an edge between existing poses and brings all poses up to date, unless it can wait.
  /// Throws as append does.
  /// Cost: the factorisation of the part of the elimination tree above the edge's poses; next to
  /// nothing when it waits.
  IncrementalUpdate add(const RelativePoseEdge& edge);
  /// The same for several edges at once, those of a key scan. None at all: brings in what waits.
  IncrementalUpdate add(const std::vector<RelativePoseEdge>& edges);

  /// Solves to convergence from the present poses, as optimize() does, and goes on from there.
  SolveResult solve(const SolverOptions& options = {});

  [[nodiscard]] const std::vector<Pose2>& poses() const;
  /// The present poses and all edges.
  [[nodiscard]] const PoseGraph& graph() const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace loopstone
