#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "loopstone/geometry/rigid_alignment.hpp"
#include "loopstone/graph/certificate.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/graph/solver.hpp"
#include "loopstone/slam/map_verdict.hpp"
#include "slam/graph_quality_numbers.hpp"
#include "slam/scan_edges.hpp"

namespace loopstone {
namespace {

/// Largest distance between two sets of positions after the best alignment.
double largest_shift_m(std::span<const Pose2> poses, std::span<const Pose2> others) {
  std::vector<Eigen::Vector2d> source;
  std::vector<Eigen::Vector2d> target;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    source.push_back(others[i].translation());
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

/// Where the solver arrives from the optimum that was proven. That one is of another objective, of
/// isotropic edges: corridors, which edges hold across and not along, come out differently there,
/// though both have their minimum in one valley.
std::vector<Pose2> solved_from(PoseGraph graph, const std::vector<Pose2>& proven) {
  graph.poses = proven;
  return optimize(graph, closure_solver()).poses;
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

bool GraphQuality::is_proven() const {
  if (!certificate) return false;
  return certificate->certified() ||
         (certificate->status == CertificateStatus::kGapOpen &&
          certificate->optimality_gap <=
              std::max(kGraphQuality.open_share * certificate->cost, kGraphQuality.open_chi2));
}

GraphQuality assess_graph(const PoseGraph& solved, std::span<const Pose2> delivered,
                          std::span<const LoopClosure> closures) {
  GraphQuality quality;
  for (const LoopClosure& closure : closures) {
    const bool revoked = closure.state == ClosureState::kRevoked;
    if (revoked) ++quality.closures_revoked;
    if (revoked || closure.stands()) ++quality.closures;
  }
  if (solved.poses.size() < 2) return quality;
  quality.loops = independent_loops(solved);
  if (quality.loops < 1) return quality;
  // Each loop closes with three numbers, each sighting of a landmark but the first with two.
  const double sightings = static_cast<double>(solved.landmark_edges.size()) -
                           static_cast<double>(solved.landmarks.size());
  quality.reduced_chi2 =
      graph_cost(solved) / (3.0 * quality.loops + 2.0 * std::max(sightings, 0.0));
  quality.adjusted_shift_m = largest_shift_m(delivered, solved.poses);
  if (solved.poses.size() > static_cast<std::size_t>(kGraphQuality.most_nodes)) return quality;
  const CertifiedSolution proven =
      optimize_certified(solved, {.max_rank = kGraphQuality.most_rank});
  quality.certificate = proven.certificate;
  if (quality.is_proven())
    quality.certified_shift_m = largest_shift_m(solved.poses, solved_from(solved, proven.poses));
  return quality;
}

}  // namespace loopstone
