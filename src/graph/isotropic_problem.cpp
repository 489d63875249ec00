#include "graph/isotropic_problem.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "loopstone/base/union_find.hpp"

namespace loopstone {

namespace {

std::size_t index(int i) { return static_cast<std::size_t>(i); }

Complex direction(double yaw) { return {std::cos(yaw), std::sin(yaw)}; }

/// 2 / tr(I^-1) for a 2x2 matrix: the trace of its inverse is its trace over its determinant.
double isotropic_translation_weight(const Eigen::Matrix2d& information) {
  const double determinant =
      information(0, 0) * information(1, 1) - information(0, 1) * information(1, 0);
  return 2.0 * determinant / (information(0, 0) + information(1, 1));
}

IsotropicEdge pose_edge(std::size_t from, std::size_t to, const Pose2& from_T_to,
                        const Eigen::Matrix3d& information) {
  return {from,
          to,
          2.0 * information(2, 2),
          isotropic_translation_weight(information.topLeftCorner<2, 2>()),
          direction(from_T_to.yaw),
          {from_T_to.x, from_T_to.y}};
}

/// The map where there are priors, else a pose that is held, else the first one.
void choose_anchors(IsotropicProblem& problem, const PoseGraph& graph) {
  std::vector<std::size_t> parents(problem.nodes);
  std::iota(parents.begin(), parents.end(), std::size_t{0});
  for (const IsotropicEdge& edge : problem.edges) join(parents, edge.from, edge.to);
  std::vector<std::size_t> anchor_of_root(problem.nodes, problem.nodes);
  const auto offer = [&](std::size_t node) {
    std::size_t& anchor = anchor_of_root[root_of(parents, node)];
    anchor = anchor == problem.nodes ? node : anchor;
  };
  if (problem.headings > problem.poses) offer(problem.poses);
  for (const NodeId node : graph.fixed) offer(index(node.index));
  for (std::size_t node = 0; node < problem.nodes; ++node) offer(node);
  problem.anchor_of.resize(problem.nodes);
  problem.anchored.resize(problem.nodes);
  for (std::size_t node = 0; node < problem.nodes; ++node) {
    problem.anchor_of[node] = anchor_of_root[root_of(parents, node)];
    problem.anchored[node] = problem.anchor_of[node] == node;
  }
}

}  // namespace

IsotropicProblem isotropic_problem(const PoseGraph& graph) {
  IsotropicProblem problem;
  problem.poses = graph.poses.size();
  problem.headings = problem.poses + (graph.priors.empty() ? 0 : 1);
  problem.nodes = problem.headings + graph.landmarks.size();
  problem.edges.reserve(graph.edges.size() + graph.priors.size() + graph.landmark_edges.size());
  for (const RelativePoseEdge& edge : graph.edges) {
    problem.edges.push_back(
        pose_edge(index(edge.from.index), index(edge.to.index), edge.from_T_to, edge.information));
  }
  for (const PosePrior& prior : graph.priors) {
    problem.edges.push_back(
        pose_edge(problem.poses, index(prior.node.index), prior.map_T_node, prior.information));
  }
  for (const LandmarkEdge& edge : graph.landmark_edges) {
    problem.edges.push_back({index(edge.from.index),
                             problem.headings + index(edge.landmark.index),
                             0.0,
                             isotropic_translation_weight(edge.information),
                             1.0,
                             {edge.point_in_from.x(), edge.point_in_from.y()}});
  }
  choose_anchors(problem, graph);
  return problem;
}

IsotropicState state_of(const PoseGraph& graph, const IsotropicProblem& problem) {
  IsotropicState state;
  state.heading.assign(problem.nodes, 1.0);
  state.position.assign(problem.nodes, 0.0);
  for (std::size_t i = 0; i < problem.poses; ++i) {
    state.heading[i] = direction(graph.poses[i].yaw);
    state.position[i] = {graph.poses[i].x, graph.poses[i].y};
  }
  for (std::size_t i = 0; i < graph.landmarks.size(); ++i) {
    state.position[problem.headings + i] = {graph.landmarks[i].x(), graph.landmarks[i].y()};
  }
  return state;
}

void write_state(const IsotropicState& state, PoseGraph& graph) {
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    graph.poses[i] = {state.position[i].real(), state.position[i].imag(),
                      std::arg(state.heading[i])};
  }
  const std::size_t first = state.position.size() - graph.landmarks.size();
  for (std::size_t i = 0; i < graph.landmarks.size(); ++i) {
    graph.landmarks[i] = {state.position[first + i].real(), state.position[first + i].imag()};
  }
}

double isotropic_cost(const IsotropicProblem& problem, const IsotropicState& state) {
  double cost = 0.0;
  for (const IsotropicEdge& edge : problem.edges) {
    const Complex z = state.heading[edge.from];
    cost += edge.rotation_weight * std::norm(state.heading[edge.to] - z * edge.turn) +
            edge.translation_weight *
                std::norm(state.position[edge.to] - state.position[edge.from] - z * edge.step);
  }
  return cost;
}

EliminationPattern elimination_pattern(const IsotropicProblem& problem) {
  std::vector<std::pair<int, int>> pairs;
  pairs.reserve(problem.edges.size());
  for (const IsotropicEdge& edge : problem.edges) {
    pairs.emplace_back(static_cast<int>(edge.from), static_cast<int>(edge.to));
  }
  return elimination_pattern(static_cast<int>(problem.nodes), pairs);
}

std::vector<EdgeBlock> edge_blocks(const IsotropicProblem& problem,
                                   const EliminationPattern& pattern) {
  std::vector<EdgeBlock> blocks;
  blocks.reserve(problem.edges.size());
  for (const IsotropicEdge& edge : problem.edges) {
    const int from = pattern.place[edge.from];
    const int to = pattern.place[edge.to];
    blocks.push_back({pattern.find(std::max(from, to), std::min(from, to)), to > from});
  }
  return blocks;
}

}  // namespace loopstone
