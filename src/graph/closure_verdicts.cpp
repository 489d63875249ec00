#include "graph/closure_verdicts.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>

#include "graph/block_cholesky.hpp"
#include "graph/descent.hpp"
#include "graph/selected_inverse.hpp"
#include "loopstone/base/median.hpp"
#include "loopstone/graph/initial_poses.hpp"

namespace loopstone {

namespace {

constexpr int kMostRounds = 40;
constexpr int kSteps = 20;
/// Of the closures that contradict the rest, those nearly as bad as the worst go together.
constexpr double kNearlyAsBad = 0.5;

/// Median of a chi-square with 3 degrees of freedom.
constexpr double kMedianChi2 = 2.366;
/// Real residuals have longer tails than the normal distribution; with fewer closures their median
/// says little.
constexpr double kSlack = 4.0;
constexpr std::size_t kFewClosures = 10;

std::size_t at(NodeId node) { return static_cast<std::size_t>(node.index); }

PoseGraph accepted_graph(const PoseGraph& graph, const std::vector<double>& weights) {
  PoseGraph result = graph;
  result.edges.clear();
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (weights[i] > 0.5) result.edges.push_back(graph.edges[i]);
  }
  return result;
}

/// The solution with the accepted closures, and the covariances that it gives to residuals.
class Solution {
 public:
  Solution(const PoseGraph& graph, const std::vector<bool>& fixed,
           const std::vector<double>& weights, GraphState& state)
      : state_(state),
        equations_(accepted_graph(graph, weights), fixed, {}),
        cholesky_(equations_.hessian()) {
    solve_from_best_start(accepted_graph(graph, weights));
    (void)equations_.linearise(state_);
    usable_ = cholesky_.factorise(equations_.hessian(), 0.0);
    if (usable_) inverse_.emplace(cholesky_);
  }

  [[nodiscard]] bool usable() const { return usable_; }

  /// Squared standard deviations by which a closure is off what the others predict. An accepted one
  /// is taken out first: the residual then has covariance information^-1 - J P J^T; for another it
  /// is information^-1 + J P J^T.
  [[nodiscard]] double disagreement(const RelativePoseEdge& edge, bool accepted) {
    const Pose2& from = state_.poses[at(edge.from)];
    const Pose2& to = state_.poses[at(edge.to)];
    const Eigen::Vector3d error = edge_error(edge, from, to);
    const EdgeJacobians j = edge_jacobians(edge, from, to);
    const Eigen::Matrix3d predicted = accepted ? within(edge, j) : across(edge, j);
    const Eigen::Matrix3d measured = edge.information.inverse();
    const Eigen::Matrix3d covariance =
        accepted ? Eigen::Matrix3d(measured - predicted) : Eigen::Matrix3d(measured + predicted);
    const Eigen::LLT<Eigen::Matrix3d> factor(0.5 * (covariance + covariance.transpose()));
    // Nothing but this closure holds its poses together: nobody contradicts it.
    if (factor.info() != Eigen::Success) return 0.0;
    return error.dot(factor.solve(error));
  }

 private:
  /// A state that false closures have folded may be a local minimum without them, so it competes
  /// with fresh starts.
  void solve_from_best_start(PoseGraph accepted) {
    accepted.poses = state_.poses;
    std::vector<GraphState> starts{state_};
    for (const Initialisation kind :
         {Initialisation::kSpanningTree, Initialisation::kOdometryChain}) {
      starts.push_back({initial_poses(accepted, kind), state_.landmarks});
    }
    double least = std::numeric_limits<double>::infinity();
    for (GraphState& start : starts) {
      const DescentResult found =
          descend(equations_, cholesky_, {DescentMethod::kGaussNewton, kSteps, 1e-8}, start);
      if (!(found.final.plain < least)) continue;
      least = found.final.plain;
      state_ = start;
    }
  }

  /// J P J^T of an edge of the solved graph, whose blocks of P are known.
  [[nodiscard]] Eigen::Matrix3d within(const RelativePoseEdge& edge, const EdgeJacobians& j) const {
    const int from = equations_.place_of(at(edge.from));
    const int to = equations_.place_of(at(edge.to));
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    if (from >= 0) sum += j.from * inverse_->block(from, from) * j.from.transpose();
    if (to >= 0) sum += j.to * inverse_->block(to, to) * j.to.transpose();
    if (from >= 0 && to >= 0) {
      const Eigen::Matrix3d mixed = j.from * inverse_->block(from, to) * j.to.transpose();
      sum += mixed + mixed.transpose();
    }
    return sum;
  }

  /// The same of any other edge.
  [[nodiscard]] Eigen::Matrix3d across(const RelativePoseEdge& edge, const EdgeJacobians& j) {
    rows_.clear();
    const int from = equations_.place_of(at(edge.from));
    const int to = equations_.place_of(at(edge.to));
    if (from >= 0) rows_.push_back({from, j.from});
    if (to >= 0) rows_.push_back({to, j.to});
    return cholesky_.through_inverse(rows_);
  }

  GraphState& state_;
  NormalEquations equations_;
  BlockCholesky cholesky_;
  bool usable_ = false;
  std::optional<SelectedInverse> inverse_;
  std::vector<BlockCholesky::RowsAt> rows_;
};

/// Many graphs come with information that is far too modest, and then a false closure hides within
/// it. How far off the accepted closures are in the middle tells the true scale (a posteriori
/// variance of unit weight, by its median); the bound is only ever made stricter.
double scaled_bound(const PoseGraph& graph, const std::vector<double>& weights,
                    const std::vector<double>& off, double inlier_chi2) {
  std::vector<double> accepted;
  for (std::size_t i = 0; i < off.size(); ++i) {
    if (graph.edges[i].kind == EdgeKind::kLoopClosure && weights[i] > 0.5) {
      accepted.push_back(off[i]);
    }
  }
  if (accepted.size() < kFewClosures) return inlier_chi2;
  return inlier_chi2 * std::min(1.0, kSlack * median_of(accepted) / kMedianChi2);
}

/// Takes out the accepted closures that contradict the rest most; false when none does. Scales the
/// bound.
bool reject_worst(const PoseGraph& graph, double& inlier_chi2, Solution& solution,
                  std::vector<double>& weights) {
  std::vector<double> off(graph.edges.size(), 0.0);
  double worst = 0.0;
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (graph.edges[i].kind != EdgeKind::kLoopClosure || weights[i] < 0.5) continue;
    off[i] = solution.disagreement(graph.edges[i], true);
    worst = std::max(worst, off[i]);
  }
  inlier_chi2 = scaled_bound(graph, weights, off, inlier_chi2);
  if (worst <= inlier_chi2) return false;
  const double bound = std::max(inlier_chi2, kNearlyAsBad * worst);
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (off[i] >= bound) weights[i] = 0.0;
  }
  return true;
}

/// Takes back the rejected closures that agree; false when none does.
bool readmit(const PoseGraph& graph, double inlier_chi2, Solution& solution,
             std::vector<double>& weights) {
  bool any = false;
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (graph.edges[i].kind != EdgeKind::kLoopClosure || weights[i] > 0.5) continue;
    if (solution.disagreement(graph.edges[i], false) > inlier_chi2) continue;
    weights[i] = 1.0;
    any = true;
  }
  return any;
}

}  // namespace

void settle_closures(const PoseGraph& graph, const std::vector<bool>& fixed, double inlier_chi2,
                     std::vector<double>& weights, GraphState& state, const StopQuestion& stop) {
  bool readmitted = false;
  for (int round = 0; round < kMostRounds && !is_stopped(stop); ++round) {
    Solution solution(graph, fixed, weights, state);
    if (!solution.usable()) return;
    double bound = inlier_chi2;
    if (reject_worst(graph, bound, solution, weights)) continue;
    // Once: what is taken out after it came back stays out.
    if (readmitted || !readmit(graph, bound, solution, weights)) return;
    readmitted = true;
  }
}

}  // namespace loopstone
