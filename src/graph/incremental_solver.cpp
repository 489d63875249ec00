#include "loopstone/graph/incremental_solver.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>

#include "graph/clique_tree.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/robust_kernel.hpp"

namespace loopstone {

namespace {

/// Times the bounds of IncrementalOptions: poses that an update moves farther are linearised anew
/// before it ends.
constexpr double kFar = 4.0;
constexpr int kFarRounds = 3;
constexpr int kFitSteps = 2;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Pose2 moved(const Pose2& pose, const Eigen::Vector3d& delta) {
  return {pose.x + delta.x(), pose.y + delta.y(), wrap_angle(pose.yaw + delta.z())};
}

/// Refuses what check_graph refuses.
void check_edge(const RelativePoseEdge& edge, int nodes) {
  PoseGraph pair;
  pair.poses.resize(2);
  pair.edges = {edge};
  pair.edges.front().from = {0};
  pair.edges.front().to = {1};
  const auto exists = [nodes](NodeId node) { return node.index >= 0 && node.index < nodes; };
  if (!exists(edge.from) || !exists(edge.to))
    throw UsageError("the edge joins a node that does not exist");
  if (edge.from == edge.to) throw UsageError("the edge joins a node to itself");
  check_graph(pair);
}

}  // namespace

class IncrementalSolver::State {
 public:
  State(PoseGraph graph, const IncrementalOptions& options)
      : graph_(std::move(graph)), options_(options) {
    restart();
  }

  /// All edges linearised at the present poses, everything eliminated.
  void restart() {
    tree_.clear();
    linearised_at_ = graph_.poses;
    factors_.clear();
    factors_of_.assign(graph_.poses.size(), {});
    forget_pending();
    for (std::size_t i = 0; i < graph_.edges.size(); ++i) add_factor(i);
    // The first pose is fixed: it is no variable, and variable i is pose i + 1.
    tree_.resize(graph_.poses.size() - 1);
    const std::vector<Pose2> solved = graph_.poses;
    if (graph_.poses.size() > 1) update_tree({});
    graph_.poses = solved;
  }

  NodeId append(const RelativePoseEdge& edge) {
    graph_.poses.push_back(graph_.poses[at(edge.from.index)] * edge.from_T_to);
    graph_.edges.push_back(edge);
    linearised_at_.push_back(graph_.poses.back());
    factors_of_.emplace_back();
    newest_from_ = pending_.size();
    pending_.push_back(graph_.edges.size() - 1);
    return edge.to;
  }

  IncrementalUpdate add(const std::vector<RelativePoseEdge>& edges) {
    const std::size_t first_new = pending_.size();
    for (const RelativePoseEdge& edge : edges) {
      graph_.edges.push_back(edge);
      pending_.push_back(graph_.edges.size() - 1);
    }
    if (edges.empty() || !can_wait(first_new)) return bring_in();
    const std::vector<int> changed = tree_.pass_on(options_.negligible_change, poses_at_once());
    move_poses(changed);
    return {.waits = true, .poses_changed = 1 + changed.size()};
  }

  SolveResult solve(const SolverOptions& options) {
    SolveResult result = optimize(graph_, options);
    graph_.poses = result.poses;
    restart();
    return result;
  }

  [[nodiscard]] const PoseGraph& graph() const { return graph_; }

 private:
  /// Whether the pending edges from `first_new` on agree so well with the rest that they need not
  /// be brought in now. If so, the newest pose lies where its own edges want it, the others held.
  bool can_wait(std::size_t first_new) {
    if (waiting_ + 1 >= options_.wait_updates) return false;
    const std::size_t first = pending_.empty() ? 0 : std::min(first_new, newest_from_);
    const std::span<const std::size_t> edges = std::span(pending_).subspan(first);
    const Pose2 before = graph_.poses.back();
    if (newest_is_free()) fit_newest(edges);
    double cost = 0.0;
    for (const std::size_t i : edges) cost += edge_cost(graph_.edges[i]).cost;
    // Also false for what is not a number.
    if (!(waiting_cost_ + cost <= options_.wait_chi2)) {
      graph_.poses.back() = before;
      return false;
    }
    linearised_at_.back() = graph_.poses.back();
    waiting_cost_ += cost;
    ++waiting_;
    return true;
  }

  /// Whether nothing but pending edges knows of the newest pose.
  [[nodiscard]] bool newest_is_free() const {
    return tree_.delta().size() + 1 < graph_.poses.size();
  }

  /// A closure's cost.
  [[nodiscard]] RobustValue robust(double chi2) const {
    return evaluate(options_.robust_kernel, options_.robust_width, chi2);
  }

  [[nodiscard]] RobustValue edge_cost(const RelativePoseEdge& edge) const {
    const double chi2 =
        edge_chi2(edge, graph_.poses[at(edge.from.index)], graph_.poses[at(edge.to.index)]);
    if (edge.kind == EdgeKind::kLoopClosure) return robust(chi2);
    return {chi2, 1.0};
  }

  /// Two steps of Gauss-Newton.
  void fit_newest(std::span<const std::size_t> edges) {
    const auto newest = static_cast<int>(graph_.poses.size()) - 1;
    for (int step = 0; step < kFitSteps; ++step) {
      Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
      Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
      for (const std::size_t i : edges) {
        const RelativePoseEdge& edge = graph_.edges[i];
        if (edge.from.index != newest && edge.to.index != newest) continue;
        const Pose2& from = graph_.poses[at(edge.from.index)];
        const Pose2& to = graph_.poses[at(edge.to.index)];
        const EdgeJacobians j = edge_jacobians(edge, from, to);
        const Eigen::Matrix3d& jacobian = edge.to.index == newest ? j.to : j.from;
        const Eigen::Matrix3d weighted =
            edge_cost(edge).weight * jacobian.transpose() * edge.information;
        hessian += weighted * jacobian;
        gradient += weighted * edge_error(edge, from, to);
      }
      const Eigen::Vector3d change = -hessian.inverse() * gradient;
      if (!change.allFinite()) break;
      graph_.poses.back() = moved(graph_.poses.back(), change);
    }
  }

  /// Eliminates what the pending edges touch.
  IncrementalUpdate bring_in() {
    std::vector<int> touched;
    const auto touch = [&](int pose) {
      if (pose > 0) touched.push_back(pose - 1);
    };
    tree_.resize(graph_.poses.size() - 1);
    for (const std::size_t edge : pending_) {
      add_factor(edge);
      touch(graph_.edges[edge].from.index);
      touch(graph_.edges[edge].to.index);
    }
    forget_pending();
    IncrementalUpdate result;
    if (++updates_ % options_.relinearise_every == 0) {
      result.poses_relinearised = relinearise(touched, 1.0);
    }
    const auto update = [&] {
      const auto [eliminated, changed] = update_tree(touched);
      result.poses_eliminated += eliminated;
      result.poses_changed = std::max(result.poses_changed, changed);
    };
    update();
    // A closure that moves poses far beyond the bounds at once is not left half solved.
    for (int round = 0; round < kFarRounds; ++round) {
      touched.clear();
      const std::size_t far = relinearise(touched, kFar);
      if (far == 0) break;
      result.poses_relinearised += far;
      update();
    }
    return result;
  }

  void forget_pending() {
    pending_.clear();
    newest_from_ = 0;
    waiting_ = 0;
    waiting_cost_ = 0.0;
  }

  void add_factor(std::size_t edge) {
    const RelativePoseEdge& e = graph_.edges[edge];
    const auto index = static_cast<int>(factors_.size());
    factors_.emplace_back();
    edge_of_factor_.resize(factors_.size());
    edge_of_factor_.back() = edge;
    linearise(index);
    for (const NodeId node : {e.from, e.to}) {
      if (node.index > 0) factors_of_[at(node.index) - 1].push_back(index);
    }
  }

  void linearise(int index) {
    const RelativePoseEdge& edge = graph_.edges[edge_of_factor_[at(index)]];
    LinearFactor& factor = factors_[at(index)];
    const Pose2& from = linearised_at_[at(edge.from.index)];
    const Pose2& to = linearised_at_[at(edge.to.index)];
    const Eigen::Vector3d error = edge_error(edge, from, to);
    const EdgeJacobians j = edge_jacobians(edge, from, to);
    const double chi2 = error.dot(edge.information * error);
    const bool closure = edge.kind == EdgeKind::kLoopClosure;
    const double weight = closure ? robust(chi2).weight : 1.0;
    const Eigen::Matrix3d from_information = weight * j.from.transpose() * edge.information;
    const Eigen::Matrix3d to_information = weight * j.to.transpose() * edge.information;
    factor = {};
    if (edge.from.index > 0 && edge.to.index > 0) {
      factor.first = edge.from.index - 1;
      factor.second = edge.to.index - 1;
      factor.first_first = from_information * j.from;
      factor.first_second = from_information * j.to;
      factor.second_second = to_information * j.to;
      factor.gradient_first = from_information * error;
      factor.gradient_second = to_information * error;
    } else if (edge.from.index > 0) {
      factor.first = edge.from.index - 1;
      factor.first_first = from_information * j.from;
      factor.gradient_first = from_information * error;
    } else {
      factor.first = edge.to.index - 1;
      factor.first_first = to_information * j.to;
      factor.gradient_first = to_information * error;
    }
  }

  /// Moves the point of linearisation of poses that have gone far from it.
  std::size_t relinearise(std::vector<int>& touched, double times) {
    const double far_m = times * options_.relinearise_m;
    const double far_rad = times * options_.relinearise_rad;
    std::size_t count = 0;
    std::vector<int> stale;
    const auto& delta = tree_.delta();
    for (std::size_t v = 0; v < delta.size(); ++v) {
      const Eigen::Vector3d& d = delta[v];
      if (d.isZero(0.0)) continue;
      if (d.head<2>().lpNorm<Eigen::Infinity>() <= far_m && std::abs(d.z()) <= far_rad) {
        continue;
      }
      ++count;
      linearised_at_[v + 1] = moved(linearised_at_[v + 1], d);
      graph_.poses[v + 1] = linearised_at_[v + 1];
      tree_.reset_delta(static_cast<int>(v));
      stale.insert(stale.end(), factors_of_[v].begin(), factors_of_[v].end());
    }
    std::sort(stale.begin(), stale.end());
    stale.erase(std::unique(stale.begin(), stale.end()), stale.end());
    for (const int f : stale) {
      linearise(f);
      touched.push_back(factors_[at(f)].first);
      if (factors_[at(f)].second >= 0) touched.push_back(factors_[at(f)].second);
    }
    return count;
  }

  std::pair<std::size_t, std::size_t> update_tree(const std::vector<int>& touched) {
    const auto newest = static_cast<int>(graph_.poses.size()) - 2;
    const CliqueTree::Result result = tree_.update(touched, newest, factors_, factors_of_,
                                                   options_.negligible_change, poses_at_once());
    if (!result.solved) {
      throw UsageError(
          "the graph's normal equations cannot be solved: is an information matrix far too large "
          "or small?");
    }
    move_poses(result.changed);
    return {result.eliminated, result.changed.size()};
  }

  void move_poses(const std::vector<int>& changed) {
    for (const int v : changed) {
      graph_.poses[at(v) + 1] = moved(linearised_at_[at(v) + 1], tree_.delta()[at(v)]);
    }
  }

  [[nodiscard]] std::size_t poses_at_once() const {
    return static_cast<std::size_t>(options_.poses_at_once);
  }

  PoseGraph graph_;
  IncrementalOptions options_;
  CliqueTree tree_;
  std::vector<Pose2> linearised_at_;
  std::vector<LinearFactor> factors_;
  std::vector<std::size_t> edge_of_factor_;
  std::vector<std::vector<int>> factors_of_;  ///< of each variable
  std::vector<std::size_t> pending_;          ///< edges that the tree does not know of yet
  std::size_t newest_from_ = 0;               ///< where those of the newest pose begin among them
  int waiting_ = 0;                           ///< updates that wait
  double waiting_cost_ = 0.0;                 ///< of their edges
  std::int64_t updates_ = 0;
};

IncrementalSolver::IncrementalSolver(const Pose2& first, const IncrementalOptions& options) {
  PoseGraph graph;
  graph.poses = {first};
  check_graph(graph);
  state_ = std::make_unique<State>(std::move(graph), options);
}

IncrementalSolver::IncrementalSolver(const PoseGraph& graph, const IncrementalOptions& options) {
  check_graph(graph);
  if (!graph.priors.empty() || !graph.landmarks.empty() || !graph.fixed.empty()) {
    throw UsageError(
        "a graph that grows is made of poses and edges alone; use optimize() for priors, landmarks "
        "and fixed poses");
  }
  if (connected_components(graph).count != 1) {
    throw UsageError("a graph that grows must be connected; join its parts or keep one of them");
  }
  PoseGraph solved = graph;
  solved.poses = optimize(graph, {.robust_kernel = options.robust_kernel,
                                  .robust_width = options.robust_width})
                     .poses;
  state_ = std::make_unique<State>(std::move(solved), options);
}

IncrementalSolver::~IncrementalSolver() = default;
IncrementalSolver::IncrementalSolver(IncrementalSolver&&) noexcept = default;
IncrementalSolver& IncrementalSolver::operator=(IncrementalSolver&&) noexcept = default;

NodeId IncrementalSolver::append(NodeId from, const Pose2& from_T_new,
                                 const Eigen::Matrix3d& information, EdgeKind kind) {
  const auto nodes = static_cast<int>(poses().size());
  const RelativePoseEdge edge{from, NodeId{nodes}, from_T_new, information, kind};
  check_edge(edge, nodes + 1);
  return state_->append(edge);
}

IncrementalUpdate IncrementalSolver::add(const RelativePoseEdge& edge) {
  check_edge(edge, static_cast<int>(poses().size()));
  return state_->add({edge});
}

IncrementalUpdate IncrementalSolver::add(const std::vector<RelativePoseEdge>& edges) {
  for (const RelativePoseEdge& edge : edges) check_edge(edge, static_cast<int>(poses().size()));
  return state_->add(edges);
}

SolveResult IncrementalSolver::solve(const SolverOptions& options) {
  return state_->solve(options);
}

const std::vector<Pose2>& IncrementalSolver::poses() const { return state_->graph().poses; }
const PoseGraph& IncrementalSolver::graph() const { return state_->graph(); }

}  // namespace loopstone
