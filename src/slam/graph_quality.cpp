#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <set>
#include <utility>
#include <vector>

#include "loopstone/geometry/rigid_alignment.hpp"
#include "loopstone/graph/certificate.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/map_verdict.hpp"

namespace loopstone {
namespace {

/// A certificate is an answer within a fraction of a second up to about this size.
constexpr std::size_t kMostNodes = 20000;

/// Largest distance between two sets of positions after the best alignment.
double largest_shift_m(const std::vector<Pose2>& poses, const std::vector<Pose2>& proven) {
  std::vector<Eigen::Vector2d> source;
  std::vector<Eigen::Vector2d> target;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    source.push_back(proven[i].translation());
    target.push_back(poses[i].translation());
  }
  const auto alignment = align_rigidly<2>(source, target);
  double largest = 0.0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const Eigen::Vector2d moved = alignment.rotation * source[i] + alignment.translation;
    largest = std::max(largest, (moved - target[i]).norm());
  }
  return largest;
}

/// Edges less nodes plus components; pairs that are joined more than once count once.
int independent_loops(const PoseGraph& graph) {
  std::set<std::pair<int, int>> joined;
  for (const RelativePoseEdge& edge : graph.edges) {
    joined.emplace(std::min(edge.from.index, edge.to.index),
                   std::max(edge.from.index, edge.to.index));
  }
  return static_cast<int>(joined.size()) - static_cast<int>(graph.poses.size()) +
         connected_components(graph).count;
}

}  // namespace

GraphQuality assess_graph(const MapResult& result) {
  GraphQuality quality;
  for (const LoopClosure& closure : result.loop_closures) {
    const bool revoked = closure.state == ClosureState::kRevoked;
    if (revoked) ++quality.closures_revoked;
    if (revoked || closure.stands()) ++quality.closures;
  }
  const PoseGraph& graph = result.graph;
  if (graph.poses.size() < 2) return quality;
  quality.loops = independent_loops(graph);
  if (quality.loops < 1) return quality;
  // Each loop closes with three numbers.
  quality.reduced_chi2 = graph_cost(graph) / (3.0 * quality.loops);
  if (graph.poses.size() > kMostNodes) return quality;
  const CertifiedSolution solution = optimize_certified(graph, {.max_rank = 2});
  quality.certificate = solution.certificate;
  if (solution.certificate.certified())
    quality.certified_shift_m = largest_shift_m(graph.poses, solution.poses);
  return quality;
}

}  // namespace loopstone
