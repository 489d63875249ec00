#include "loopstone/slam/pose_covariances.hpp"

#include <Eigen/LU>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "loopstone/base/robust_kernel.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "loopstone/graph/linearised_graph.hpp"
#include "slam/path_posterior.hpp"
#include "slam/scan_edges.hpp"
#include "slam/surface_adjustment_numbers.hpp"
#include "slam/surface_segments.hpp"
#include "slam/surface_system.hpp"

namespace loopstone {

namespace {

using Link = SurfaceSegments::Link;

/// A map is as large as the laser's ranges say, or the wheels that agree with them.
Eigen::Matrix3d of_scale(const Eigen::Vector2d& apart) {
  const Eigen::Vector2d error = kSurfaceAdjustment.range_scale_sigma * apart;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  covariance.topLeftCorner<2, 2>() = error * error.transpose();
  return covariance;
}

Eigen::Matrix3d turned(const Pose2& pose) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = pose.rotation();
  return turn;
}

/// Covariance of an edge at its end, axes of the map.
Eigen::Matrix3d on_map(const RelativePoseEdge& edge, const Pose2& to) {
  const Eigen::Matrix3d turn = turned(to);
  return turn * edge.information.inverse() * turn.transpose();
}

/// The chain of a path: covariances from each pose to the next, and whether they are known.
struct Chain {
  std::vector<Eigen::Matrix3d> to;
  std::vector<bool> known;
};

class Links {
 public:
  Links(const PoseGraph& graph, std::span<const int> places, const SurfaceSegments& segments)
      : graph_(graph), places_(places) {
    chain_.to.resize(graph.poses.size(), Eigen::Matrix3d::Zero());
    chain_.known.resize(graph.poses.size(), false);
    for (const RelativePoseEdge& edge : graph.edges) add(edge);
    for (const LinkAlong& along :
         links_along(graph.poses, places, segments, chain_.to, chain_.known))
      links_.push_back(along.link);
  }
  [[nodiscard]] const std::vector<Link>& links() const { return links_; }

 private:
  [[nodiscard]] const Pose2& pose(int node) const {
    return graph_.poses[static_cast<std::size_t>(node)];
  }
  [[nodiscard]] int place(int node) const { return places_[static_cast<std::size_t>(node)]; }

  void add(const RelativePoseEdge& edge) {
    const Eigen::Matrix3d covariance = on_map(edge, pose(edge.to.index));
    const auto to = static_cast<std::size_t>(edge.to.index);
    if (edge.kind != EdgeKind::kLoopClosure && edge.from.index + 1 == edge.to.index &&
        !chain_.known[to]) {
      chain_.to[to] = covariance;
      chain_.known[to] = true;
    } else {
      link(edge.from.index, edge.to.index, covariance);
    }
  }

  /// \param covariance  of the motion between two poses, at the second one, axes of the map
  void link(int from, int to, const Eigen::Matrix3d& covariance) {
    if (place(to) < 0 && place(from) < 0) return;
    const Eigen::Vector2d from_T_to = pose(to).translation() - pose(from).translation();
    if (place(to) < 0) {
      // Seen from the one that is held.
      const Eigen::Matrix3d back = lever_of(-from_T_to);
      links_.push_back(
          {.to = place(from), .information = (back * covariance * back.transpose()).inverse()});
      return;
    }
    links_.push_back({.from = place(from),
                      .to = place(to),
                      .from_T_point = from_T_to,
                      .information = covariance.inverse()});
  }

  const PoseGraph& graph_;
  std::span<const int> places_;
  Chain chain_{};
  std::vector<Link> links_{};
};

}  // namespace

struct PoseCovariances::Knowledge {
  std::vector<Pose2> poses;
  std::vector<int> places;
  std::vector<Eigen::Matrix3d> own;  ///< of a pose while all others stand still, axes of the map
  SurfaceSegments segments;
  std::vector<std::optional<Eigen::Matrix3d>> of_segments{};  ///< those that were asked for

  [[nodiscard]] const Eigen::Matrix3d& of_segment(int segment) {
    const auto at = static_cast<std::size_t>(segment);
    if (of_segments.size() <= at) of_segments.resize(at + 1);
    if (!of_segments[at]) {
      const BlockSolver::RowsAt rows{segment, Eigen::Matrix3d::Identity()};
      of_segments[at] = segments.through_inverse({&rows, 1});
    }
    return *of_segments[at];
  }
  [[nodiscard]] const Pose2& pose(NodeId node) const {
    return poses[static_cast<std::size_t>(node.index)];
  }
  [[nodiscard]] int place(NodeId node) const {
    return places[static_cast<std::size_t>(node.index)];
  }
  [[nodiscard]] Eigen::Matrix3d own_of(NodeId node) const {
    return own[static_cast<std::size_t>(node.index)];
  }
};

PoseCovariances::PoseCovariances(const PoseGraph& graph, const SurfaceSystem* surfaces,
                                 const std::vector<bool>& broken) {
  if (graph.poses.empty()) return;
  LinearisedGraph equations(graph, RobustKernel::kHuber, kClosureHuberWidth);
  equations.linearise({graph.poses, graph.landmarks});
  std::vector<int> places;
  for (int i = 0; i < static_cast<int>(graph.poses.size()); ++i)
    places.push_back(equations.place_of(NodeId{i}));
  Knowledge knowledge{graph.poses,
                      places,
                      {},
                      SurfaceSegments(graph.poses, places, equations.gradient().size(), broken)};
  for (const int place : places) {
    knowledge.own.emplace_back(Eigen::Matrix3d::Zero());
    if (place < 0) continue;
    Eigen::Matrix3d information = equations.hessian().diagonal[static_cast<std::size_t>(place)];
    if (surfaces != nullptr) information += surfaces->diagonal()[static_cast<std::size_t>(place)];
    knowledge.own.back() = information.inverse();
  }
  const Links links(graph, places, knowledge.segments);
  if (!knowledge.segments.factorise(surfaces, links.links())) return;
  knowledge_ = std::make_shared<Knowledge>(std::move(knowledge));
}

Eigen::Matrix3d PoseCovariances::of(NodeId node) const {
  const int place = knowledge_->place(node);
  if (place < 0) return Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d motion = knowledge_->segments.motion_at(place, Eigen::Vector2d::Zero());
  const Eigen::Matrix3d& of_segment =
      knowledge_->of_segment(knowledge_->segments.segment_of(place));
  Eigen::Matrix3d covariance =
      motion * of_segment * motion.transpose() + knowledge_->own_of(node) +
      of_scale(knowledge_->pose(node).translation() - knowledge_->poses.front().translation());
  if (turned_rad_ == 0.0) return covariance;
  return rotated(covariance, Pose2{0.0, 0.0, turned_rad_}.rotation());
}

Eigen::Matrix3d PoseCovariances::between(NodeId from, NodeId to) const {
  const Eigen::Vector2d apart =
      knowledge_->pose(to).translation() - knowledge_->pose(from).translation();
  const Eigen::Matrix3d turn = turned(knowledge_->pose(from)).transpose();
  std::vector<BlockSolver::RowsAt> rows;
  SurfaceSegments& segments = knowledge_->segments;
  const auto add = [&](NodeId node, const Eigen::Vector2d& offset, double sign) {
    const int place = knowledge_->place(node);
    if (place < 0) return;
    rows.push_back({segments.segment_of(place), sign * turn * segments.motion_at(place, offset)});
  };
  add(to, Eigen::Vector2d::Zero(), 1.0);
  add(from, apart, -1.0);
  const Eigen::Matrix3d swung = lever_of(apart);
  const Eigen::Matrix3d own = knowledge_->own_of(to) + of_scale(apart) +
                              swung * knowledge_->own_of(from) * swung.transpose();
  return segments.through_inverse(rows) + turn * own * turn.transpose();
}

}  // namespace loopstone
