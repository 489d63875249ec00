#include "graph/closure_loops.hpp"

#include <Eigen/LU>

#include "geometry/symmetric_matrix.hpp"

namespace loopstone {

namespace {

std::size_t at(NodeId node) { return static_cast<std::size_t>(node.index); }

Eigen::Matrix3d seen_from(const Pose2& frame, const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d a = adjoint(frame);
  return a * covariance * a.transpose();
}

}  // namespace

ClosureLoops::ClosureLoops(const PoseGraph& graph)
    : poses_(graph.poses.size()),
      grown_(graph.poses.size(), Eigen::Matrix3d::Zero()),
      part_(graph.poses.size(), 0) {
  const std::size_t size = graph.poses.size();
  std::vector<const RelativePoseEdge*> to_next(size, nullptr);
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    const RelativePoseEdge& edge = graph.edges[i];
    if (edge.kind == EdgeKind::kLoopClosure) {
      const Eigen::Matrix3d covariance = edge.information.inverse();
      if (edge.from.index < edge.to.index) {
        closures_.push_back({i, at(edge.from), at(edge.to), edge.from_T_to, covariance});
      } else {
        closures_.push_back({i, at(edge.to), at(edge.from), edge.from_T_to.inverse(),
                             seen_from(edge.from_T_to, covariance)});
      }
      continue;
    }
    if (edge.to.index - edge.from.index == 1) to_next[at(edge.from)] = &edge;
    if (edge.from.index - edge.to.index == 1) to_next[at(edge.to)] = &edge;
  }
  for (std::size_t i = 0; i + 1 < size; ++i) {
    const RelativePoseEdge* edge = to_next[i];
    if (edge == nullptr) {
      part_[i + 1] = part_[i] + 1;
      continue;
    }
    part_[i + 1] = part_[i];
    const bool forward = edge->from.index == static_cast<int>(i);
    const Pose2 step = forward ? edge->from_T_to : edge->from_T_to.inverse();
    poses_[i + 1] = poses_[i] * step;
    // The error stands at the measured end, in its axes.
    const Pose2& end = forward ? poses_[i + 1] : poses_[i];
    grown_[i + 1] = grown_[i] + seen_from(end, edge->information.inverse());
  }
}

ClosureLoops::Opening ClosureLoops::opening(const ComparedClosure& a,
                                            const ComparedClosure& b) const {
  const Pose2& a_from = poses_[a.from];
  const Pose2& b_from = poses_[b.from];
  const Pose2 b_to = b_from * b.from_T_to;            // by way of b
  const Pose2 shift = b_to * poses_[b.to].inverse();  // of the second stretch of odometry
  const Pose2 there = shift * poses_[a.to];
  const Pose2 direct = a_from * a.from_T_to;
  const Pose2 error = there.inverse() * direct;
  Eigen::Matrix3d covariance = stretch(a.from, b.from);
  covariance += seen_from(b_to, b.covariance);
  covariance += seen_from(shift, stretch(b.to, a.to));
  covariance += seen_from(direct, a.covariance);
  // To the frame of the error, the end of the loop; the determinant stays what it is.
  const Eigen::Matrix3d local = seen_from(there.inverse(), covariance);
  const Tangent2 twist = log(error);
  return {twist.dot(solve_symmetric(local, Eigen::Vector3d(twist))), local.determinant()};
}

}  // namespace loopstone
