#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "graph/block_cholesky.hpp"
#include "graph/closure_verdicts.hpp"
#include "graph/descent.hpp"
#include "graph/gauge.hpp"
#include "graph/normal_equations.hpp"
#include "graph/supported_closures.hpp"
#include "loopstone/graph/initial_poses.hpp"
#include "loopstone/graph/outlier_rejection.hpp"

namespace loopstone {

namespace {

/// A weight below which an edge is left out of a round.
constexpr double kNoWeight = 1e-9;
/// Steps of Gauss-Newton per round: the next round starts from there.
constexpr int kStepsPerRound = 3;

/// Cost per degree of freedom above which a solution is doubted.
constexpr double kStrain = 2.0;

/// Up to so many closures the other starts cost next to nothing, and are always tried.
constexpr std::ptrdiff_t kFewClosures = 200;

bool judged(const RelativePoseEdge& edge) { return edge.kind == EdgeKind::kLoopClosure; }

/// Yang et al. 2020, eq. 14: weights of truncated least squares, softened by mu (0: convex,
/// infinity: truncated).
double softened_weight(double chi2, double inlier_chi2, double mu) {
  if (chi2 <= mu / (mu + 1.0) * inlier_chi2) return 1.0;
  if (chi2 >= (mu + 1.0) / mu * inlier_chi2) return 0.0;
  return std::sqrt(inlier_chi2 / chi2 * mu * (mu + 1.0)) - mu;
}

std::vector<double> chi2_of_edges(const PoseGraph& graph, const GraphState& state) {
  std::vector<double> result;
  result.reserve(graph.edges.size());
  for (const RelativePoseEdge& edge : graph.edges) {
    result.push_back(edge_chi2(edge, state.poses[static_cast<std::size_t>(edge.from.index)],
                               state.poses[static_cast<std::size_t>(edge.to.index)]));
  }
  return result;
}

/// The graph with the edges that weigh something, their information scaled.
PoseGraph weighted(const PoseGraph& graph, const std::vector<double>& weights) {
  PoseGraph result = graph;
  result.edges.clear();
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (weights[i] <= kNoWeight) continue;
    result.edges.push_back(graph.edges[i]);
    result.edges.back().information *= weights[i];
  }
  return result;
}

void improve(const PoseGraph& graph, const std::vector<double>& weights,
             const std::vector<bool>& fixed, GraphState& state) {
  const PoseGraph present = weighted(graph, weights);
  NormalEquations equations(present, fixed, {});
  BlockCholesky cholesky(equations.hessian());
  (void)descend(equations, cholesky, {DescentMethod::kGaussNewton, kStepsPerRound, 1e-4}, state);
}

/// Odometry and what is trusted, for a start.
GraphState start_of(const PoseGraph& graph, const GncOptions& options) {
  GraphState state{graph.poses, graph.landmarks};
  if (options.start_from_odometry) {
    state.poses = initial_poses(graph, Initialisation::kOdometryChain);
  }
  return state;
}

/// Which closures a solution stands on.
struct Verdict {
  GraphState state;
  std::vector<double> weights;
  int rounds = 0;
};

/// Sum of min(chi2, inlier_chi2) over the judged edges, chi2 over the others: what truncated least
/// squares minimises.
double truncated_cost(const PoseGraph& graph, const Verdict& verdict, double inlier_chi2) {
  const std::vector<double> chi2 = chi2_of_edges(graph, verdict.state);
  double cost = 0.0;
  for (std::size_t i = 0; i < chi2.size(); ++i) {
    cost += judged(graph.edges[i]) ? std::min(chi2[i], inlier_chi2) : chi2[i];
  }
  return cost;
}

/// Whether what was accepted fits badly as a whole: a false closure that odometry gives way to
/// raises the cost elsewhere.
bool strained(const PoseGraph& graph, const Verdict& verdict) {
  const std::vector<double> chi2 = chi2_of_edges(graph, verdict.state);
  double cost = 0.0;
  double freedom = -3.0 * static_cast<double>(graph.poses.size());
  for (std::size_t i = 0; i < chi2.size(); ++i) {
    if (verdict.weights[i] < 0.5) continue;
    cost += chi2[i];
    freedom += 3.0;
  }
  return cost > kStrain * std::max(freedom, 1.0);
}

void decide(const PoseGraph& graph, std::vector<double>& weights) {
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (judged(graph.edges[i])) weights[i] = weights[i] > 0.5 ? 1.0 : 0.0;
  }
}

/// From odometry alone: closures that it can reach come in together, and the worst go out one after
/// another.
Verdict judge_from_odometry(const PoseGraph& graph, const GncOptions& options,
                            const std::vector<bool>& fixed, const StopQuestion& stop) {
  Verdict verdict{start_of(graph, options), std::vector<double>(graph.edges.size(), 1.0)};
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (judged(graph.edges[i])) verdict.weights[i] = 0.0;
  }
  settle_closures(graph, fixed, options.inlier_chi2, verdict.weights, verdict.state, stop);
  return verdict;
}

/// \param candidates  by edge: closures that are none stay out of the rounds
Verdict judge_by_rounds(const PoseGraph& graph, const GncOptions& options,
                        const std::vector<bool>& fixed, const std::vector<bool>& candidates,
                        const StopQuestion& stop) {
  GraphState state = start_of(graph, options);
  std::vector<double> weights(graph.edges.size(), 1.0);
  const auto judged_here = [&](std::size_t i) { return judged(graph.edges[i]) && candidates[i]; };
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (judged(graph.edges[i]) && !candidates[i]) weights[i] = 0.0;
  }
  if (options.consistency_first) {
    for (std::size_t i = 0; i < graph.edges.size(); ++i) {
      if (judged(graph.edges[i])) weights[i] = 0.0;
    }
    for (const std::size_t edge :
         consistent_closures(graph, {.consistent_chi2 = options.inlier_chi2}).edges) {
      weights[edge] = 1.0;
    }
  }
  double mu = 0.0;
  int round = 0;
  for (; round < options.max_rounds && !is_stopped(stop); ++round) {
    improve(graph, weights, fixed, state);
    const std::vector<double> chi2 = chi2_of_edges(graph, state);
    if (round == 0) {
      double worst = 0.0;
      for (std::size_t i = 0; i < chi2.size(); ++i) {
        if (judged_here(i)) worst = std::max(worst, chi2[i]);
      }
      if (2.0 * worst <= options.inlier_chi2) break;  // nothing to reject
      mu = options.inlier_chi2 / (2.0 * worst - options.inlier_chi2);
    } else {
      mu *= options.sharpening;
    }
    bool undecided = false;
    bool changed = false;
    for (std::size_t i = 0; i < chi2.size(); ++i) {
      if (!judged_here(i)) continue;
      const double weight = softened_weight(chi2[i], options.inlier_chi2, mu);
      undecided = undecided || (weight > 0.0 && weight < 1.0);
      changed = changed || weight != weights[i];
      weights[i] = weight;
    }
    if (!undecided && !changed) break;
  }

  decide(graph, weights);
  settle_closures(graph, fixed, options.inlier_chi2, weights, state, stop);
  return {std::move(state), std::move(weights), round};
}

}  // namespace

GncResult optimize_gnc(const PoseGraph& graph, const GncOptions& options,
                       const SolverOptions& solver, const StopQuestion& stop) {
  check_graph(graph);
  const std::vector<bool> fixed = gauge_of(graph, connected_components(graph)).fixed;
  const std::vector<bool> all(graph.edges.size(), true);
  const auto closures = std::count_if(graph.edges.begin(), graph.edges.end(), judged);
  const bool few = closures <= kFewClosures;
  Verdict verdict = judge_by_rounds(
      graph, options, fixed, few ? all : supported_closures(graph, options.inlier_chi2), stop);
  // Other ways to begin end elsewhere; the least truncated cost wins.
  const auto compete = [&](Verdict next) {
    if (truncated_cost(graph, next, options.inlier_chi2) <
        truncated_cost(graph, verdict, options.inlier_chi2)) {
      verdict = std::move(next);
    }
  };
  const auto again = [&] { return !is_stopped(stop) && (few || strained(graph, verdict)); };
  if (again()) compete(judge_from_odometry(graph, options, fixed, stop));
  if (again()) {
    GncOptions other = options;
    other.consistency_first = !options.consistency_first;
    compete(judge_by_rounds(graph, other, fixed, all, stop));
  }
  auto& [state, weights, rounds] = verdict;
  GncResult result;
  result.rounds = rounds;
  PoseGraph accepted = weighted(graph, weights);
  accepted.poses = std::move(state.poses);
  accepted.landmarks = std::move(state.landmarks);
  result.solved = optimize(accepted, solver, stop);
  state = {result.solved.poses, result.solved.landmarks};
  result.edge_chi2 = chi2_of_edges(graph, state);
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (judged(graph.edges[i])) ++(weights[i] > 0.5 ? result.accepted : result.rejected);
  }
  result.solved.edge_weights = std::move(weights);
  return result;
}

}  // namespace loopstone
