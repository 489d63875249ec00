#include "loopstone/graph/initial_poses.hpp"

#include <algorithm>
#include <utility>

#include "graph/chordal.hpp"

namespace loopstone {

namespace {

/// An edge as seen from one of its nodes.
struct Neighbour {
  std::size_t node = 0;
  Pose2 here_T_node;
};

std::vector<std::vector<Neighbour>> neighbours_of_nodes(const PoseGraph& graph) {
  std::vector<std::vector<Neighbour>> result(graph.poses.size());
  for (const RelativePoseEdge& edge : graph.edges) {
    const auto from = static_cast<std::size_t>(edge.from.index);
    const auto to = static_cast<std::size_t>(edge.to.index);
    result[from].push_back({to, edge.from_T_to});
    result[to].push_back({from, edge.from_T_to.inverse()});
  }
  return result;
}

/// Poses that follow one another along edges, from those that are known.
std::vector<Pose2> poses_along_edges(const PoseGraph& graph, bool chain_first) {
  const auto neighbours = neighbours_of_nodes(graph);
  std::vector<Pose2> poses = graph.poses;
  std::vector<bool> placed(poses.size(), false);
  std::vector<std::size_t> queue;

  const auto place = [&](std::size_t from, const Neighbour& neighbour) {
    poses[neighbour.node] = poses[from] * neighbour.here_T_node;
    placed[neighbour.node] = true;
    queue.push_back(neighbour.node);
  };
  const auto place_successors = [&](std::size_t node) {
    while (node + 1 < poses.size() && !placed[node + 1]) {
      const auto next = std::find_if(neighbours[node].begin(), neighbours[node].end(),
                                     [node](const Neighbour& n) { return n.node == node + 1; });
      if (next == neighbours[node].end()) return;
      place(node, *next);
      ++node;
    }
  };
  std::size_t head = 0;
  const auto spread = [&] {
    for (; head < queue.size(); ++head) {
      const std::size_t node = queue[head];
      if (chain_first) place_successors(node);
      for (const Neighbour& neighbour : neighbours[node]) {
        if (placed[neighbour.node]) continue;
        place(node, neighbour);
        if (chain_first) place_successors(neighbour.node);
      }
    }
  };
  const auto begin_at = [&](std::size_t node) {
    placed[node] = true;
    queue.push_back(node);
  };

  for (const NodeId node : graph.fixed) begin_at(static_cast<std::size_t>(node.index));
  spread();
  for (const PosePrior& prior : graph.priors) {
    const auto node = static_cast<std::size_t>(prior.node.index);
    if (placed[node]) continue;
    poses[node] = prior.map_T_node;
    begin_at(node);
    spread();
  }
  for (std::size_t node = 0; node < poses.size(); ++node) {
    if (placed[node]) continue;
    begin_at(node);
    spread();
  }
  return poses;
}

std::vector<Pose2> chordal_poses(const PoseGraph& graph) {
  const IsotropicSystem system = isotropic_system(graph);
  const PositionSolver positions(system);
  PoseGraph result = graph;
  write_state(chordal_state(system, positions, state_of(graph, system.problem)), result);
  for (const NodeId node : graph.fixed) {
    const auto i = static_cast<std::size_t>(node.index);
    result.poses[i] = graph.poses[i];
  }
  return std::move(result.poses);
}

}  // namespace

std::vector<Pose2> initial_poses(const PoseGraph& graph, Initialisation initialisation) {
  switch (initialisation) {
    case Initialisation::kOdometryChain:
      return poses_along_edges(graph, true);
    case Initialisation::kSpanningTree:
      return poses_along_edges(graph, false);
    case Initialisation::kChordal:
      return chordal_poses(graph);
    case Initialisation::kAsGiven:
      break;
  }
  return graph.poses;
}

std::vector<Eigen::Vector2d> initial_landmarks(const PoseGraph& graph) {
  std::vector<Eigen::Vector2d> sums(graph.landmarks.size(), Eigen::Vector2d::Zero());
  std::vector<int> counts(graph.landmarks.size(), 0);
  for (const LandmarkEdge& edge : graph.landmark_edges) {
    const auto landmark = static_cast<std::size_t>(edge.landmark.index);
    sums[landmark] += graph.poses[static_cast<std::size_t>(edge.from.index)] * edge.point_in_from;
    ++counts[landmark];
  }
  for (std::size_t i = 0; i < sums.size(); ++i) {
    sums[i] = counts[i] > 0 ? Eigen::Vector2d(sums[i] / counts[i]) : graph.landmarks[i];
  }
  return sums;
}

GraphStart make_start(const PoseGraph& graph, Initialisation initialisation) {
  if (initialisation == Initialisation::kAsGiven) {
    return {initialisation, graph.poses, graph.landmarks, graph_cost(graph)};
  }
  PoseGraph placed = graph;
  placed.poses = initial_poses(graph, initialisation);
  placed.landmarks = initial_landmarks(placed);
  const double cost = graph_cost(placed);
  return {initialisation, std::move(placed.poses), std::move(placed.landmarks), cost};
}

GraphStart best_start(const PoseGraph& graph, bool poses_given) {
  GraphStart best = make_start(graph, Initialisation::kChordal);
  const auto offer = [&](Initialisation initialisation) {
    GraphStart start = make_start(graph, initialisation);
    if (start.cost < best.cost) best = std::move(start);
  };
  offer(Initialisation::kSpanningTree);
  offer(Initialisation::kOdometryChain);
  if (poses_given) offer(Initialisation::kAsGiven);
  return best;
}

}  // namespace loopstone
