#include "loopstone/graph/initial_poses.hpp"

#include <algorithm>

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

}  // namespace

std::vector<Pose2> initial_poses(const PoseGraph& graph, Initialisation initialisation) {
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

  for (std::size_t first = 0; first < poses.size(); ++first) {
    if (placed[first]) continue;
    placed[first] = true;
    queue.assign(1, first);
    if (initialisation == Initialisation::kOdometryChain) place_successors(first);
    for (std::size_t head = 0; head < queue.size(); ++head) {
      const std::size_t node = queue[head];
      for (const Neighbour& neighbour : neighbours[node]) {
        if (placed[neighbour.node]) continue;
        place(node, neighbour);
        if (initialisation == Initialisation::kOdometryChain) place_successors(neighbour.node);
      }
    }
  }
  return poses;
}

}  // namespace loopstone
