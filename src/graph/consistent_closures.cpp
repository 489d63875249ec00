#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "loopstone/graph/outlier_rejection.hpp"

namespace loopstone {

namespace {

std::size_t at(NodeId node) { return static_cast<std::size_t>(node.index); }

/// The chain of odometry, and how its uncertainty grows: the covariance of the way from pose i to pose k, as a twist in the
/// frame in which the chain is told, is grown[k] - grown[i].
struct Chain {
  std::vector<Pose2> poses;
  std::vector<Eigen::Matrix3d> grown;
  std::vector<int> part;  ///< poses of different parts are not joined by odometry
};

Eigen::Matrix3d seen_from(const Pose2& frame, const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d a = adjoint(frame);
  return a * covariance * a.transpose();
}

Chain odometry_chain(const PoseGraph& graph) {
  const std::size_t size = graph.poses.size();
  std::vector<const RelativePoseEdge*> to_next(size, nullptr);
  for (const RelativePoseEdge& edge : graph.edges) {
    if (edge.kind == EdgeKind::kLoopClosure) continue;
    if (edge.to.index - edge.from.index == 1) to_next[at(edge.from)] = &edge;
    if (edge.from.index - edge.to.index == 1) to_next[at(edge.to)] = &edge;
  }
  Chain chain{std::vector<Pose2>(size), std::vector<Eigen::Matrix3d>(size, Eigen::Matrix3d::Zero()),
              std::vector<int>(size, 0)};
  for (std::size_t i = 0; i + 1 < size; ++i) {
    const RelativePoseEdge* edge = to_next[i];
    if (edge == nullptr) {
      chain.part[i + 1] = chain.part[i] + 1;
      continue;
    }
    chain.part[i + 1] = chain.part[i];
    const bool forward = edge->from.index == static_cast<int>(i);
    const Pose2 step = forward ? edge->from_T_to : edge->from_T_to.inverse();
    chain.poses[i + 1] = chain.poses[i] * step;
    // The error stands at the measured end, in its axes.
    const Pose2& end = forward ? chain.poses[i + 1] : chain.poses[i];
    chain.grown[i + 1] = chain.grown[i] + seen_from(end, edge->information.inverse());
  }
  return chain;
}

/// A closure with what every comparison needs.
struct Closure {
  std::size_t from = 0;
  std::size_t to = 0;
  Pose2 from_T_to;
  Eigen::Matrix3d covariance;  ///< twist at the end
};

/// How open the loop of two closures and the odometry between them is, in squared standard deviations:
/// a.from -> b.from by odometry, b, b.to -> a.to by odometry, a backwards. Mangelson et al. 2018, eq. 8.
double disagreement(const Chain& chain, const Closure& a, const Closure& b) {
  const Pose2& a_from = chain.poses[a.from];
  const Pose2& b_from = chain.poses[b.from];
  const Pose2 b_to = b_from * b.from_T_to;                 // by way of b
  const Pose2 shift = b_to * chain.poses[b.to].inverse();  // of the second stretch of odometry
  const Pose2 there = shift * chain.poses[a.to];
  const Pose2 direct = a_from * a.from_T_to;
  const Pose2 error = there.inverse() * direct;
  const auto stretch = [&chain](std::size_t i, std::size_t k) {
    return Eigen::Matrix3d(chain.grown[std::max(i, k)] - chain.grown[std::min(i, k)]);
  };
  Eigen::Matrix3d covariance = stretch(a.from, b.from);
  covariance += seen_from(b_to, b.covariance);
  covariance += seen_from(shift, stretch(b.to, a.to));
  covariance += seen_from(direct, a.covariance);
  // To the frame of the error, the end of the loop.
  const Eigen::Matrix3d local = seen_from(there.inverse(), covariance);
  const Tangent2 twist = log(error);
  return twist.dot(local.ldlt().solve(twist));
}

}  // namespace

ConsistentClosures consistent_closures(const PoseGraph& graph, const ConsistencyOptions& options) {
  check_graph(graph);
  const Chain chain = odometry_chain(graph);
  std::vector<Closure> closures;
  std::vector<std::size_t> edge_of;
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    const RelativePoseEdge& edge = graph.edges[i];
    if (edge.kind != EdgeKind::kLoopClosure) continue;
    closures.push_back({at(edge.from), at(edge.to), edge.from_T_to, edge.information.inverse()});
    edge_of.push_back(i);
  }
  std::vector<std::vector<bool>> adjacent(closures.size(),
                                          std::vector<bool>(closures.size(), false));
  for (std::size_t i = 0; i < closures.size(); ++i) {
    for (std::size_t k = i + 1; k < closures.size(); ++k) {
      const bool joined = chain.part[closures[i].from] == chain.part[closures[k].from] &&
                          chain.part[closures[i].to] == chain.part[closures[k].to];
      if (!joined) continue;
      const bool agree = disagreement(chain, closures[i], closures[k]) <= options.consistent_chi2;
      adjacent[i][k] = agree;
      adjacent[k][i] = agree;
    }
  }
  const Clique clique = greatest_clique(adjacent, options.exact_up_to);
  ConsistentClosures result;
  result.exact = clique.exact;
  for (const int node : clique.nodes)
    result.edges.push_back(edge_of[static_cast<std::size_t>(node)]);
  return result;
}

}  // namespace loopstone
