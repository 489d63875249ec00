#include "loopstone/graph/marginals.hpp"

#include <cmath>
#include <cstddef>
#include <map>
#include <string>

#include "graph/block_cholesky.hpp"
#include "graph/gauge.hpp"
#include "graph/normal_equations.hpp"
#include "graph/selected_inverse.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {

namespace {

/// Columns of the inverse of the normal equations' matrix.
class InverseColumns {
 public:
  explicit InverseColumns(const PoseGraph& graph)
      : equations_(graph, gauge_of(graph, connected_components(graph)).fixed, {}),
        cholesky_(equations_.hessian()) {
    (void)equations_.linearise({graph.poses, graph.landmarks});
    factorised_ = cholesky_.factorise(equations_.hessian(), 0.0);
  }

  [[nodiscard]] bool available() const { return factorised_; }

  /// The blocks of the columns of `column` at the poses `rows`; zero where either is fixed.
  [[nodiscard]] std::vector<Eigen::Matrix3d> blocks(NodeId column, std::span<const NodeId> rows) {
    std::vector<Eigen::Matrix3d> result(rows.size(), Eigen::Matrix3d::Zero());
    const int place = place_of(column);
    if (place < 0) return result;
    for (int k = 0; k < 3; ++k) {
      (void)this->column(place, k);
      for (std::size_t i = 0; i < rows.size(); ++i) {
        const int row = place_of(rows[i]);
        if (row >= 0) result[i].col(k) = x_[static_cast<std::size_t>(row)];
      }
    }
    return result;
  }

  /// A whole column; good until the next.
  [[nodiscard]] const std::vector<Eigen::Vector3d>& column(int place, int k) {
    x_.assign(equations_.gradient().size(), Eigen::Vector3d::Zero());
    x_[static_cast<std::size_t>(place)](k) = 1.0;
    cholesky_.solve_in_place(x_);
    return x_;
  }

  /// The blocks on the diagonal, among others, all at once.
  [[nodiscard]] SelectedInverse selected() { return SelectedInverse(cholesky_); }

  /// Row of a pose's block; negative where the pose is fixed.
  [[nodiscard]] int place_of(NodeId node) const {
    return equations_.place_of(static_cast<std::size_t>(node.index));
  }

  [[nodiscard]] int place_of(LandmarkId landmark) const {
    return equations_.place_of_landmark(static_cast<std::size_t>(landmark.index));
  }

 private:
  NormalEquations equations_;
  BlockCholesky cholesky_;
  bool factorised_ = false;
  std::vector<Eigen::Vector3d> x_;
};

void check_node(const PoseGraph& graph, NodeId node) {
  if (node.index < 0 || node.index >= static_cast<int>(graph.poses.size())) {
    throw UsageError("covariance of node " + std::to_string(node.index) + ", which does not exist");
  }
}

Eigen::Matrix3d symmetric(const Eigen::Matrix3d& m) { return 0.5 * (m + m.transpose()); }

/// Where landmarks stand in the equations. Throws for one that does not exist or that no pose sees.
std::vector<int> places_of(const PoseGraph& graph, const InverseColumns& inverse,
                           std::span<const LandmarkId> landmarks) {
  std::vector<int> places;
  for (const LandmarkId landmark : landmarks) {
    const auto name = "covariance of landmark " + std::to_string(landmark.index);
    if (landmark.index < 0 || landmark.index >= static_cast<int>(graph.landmarks.size()))
      throw UsageError(name + ", which does not exist");
    places.push_back(inverse.place_of(landmark));
    if (places.back() < 0) throw UsageError(name + ", which no pose sees");
  }
  return places;
}

}  // namespace

PoseMarginals marginal_covariances(const PoseGraph& graph, std::span<const NodeId> nodes) {
  check_graph(graph);
  for (const NodeId node : nodes) check_node(graph, node);
  InverseColumns inverse(graph);
  PoseMarginals result;
  result.available = inverse.available();
  if (!result.available) return result;
  const SelectedInverse selected = inverse.selected();
  for (const NodeId node : nodes) {
    const int place = inverse.place_of(node);
    result.covariances.push_back(place < 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Zero())
                                           : symmetric(selected.block(place, place)));
  }
  return result;
}

LandmarkMarginals landmark_covariances(const PoseGraph& graph,
                                       std::span<const LandmarkId> landmarks) {
  check_graph(graph);
  InverseColumns inverse(graph);
  LandmarkMarginals result;
  result.available = inverse.available();
  const std::vector<int> places = places_of(graph, inverse, landmarks);
  if (!result.available) return result;
  const SelectedInverse selected = inverse.selected();
  for (const int place : places) {
    const Eigen::Matrix3d block = symmetric(selected.block(place, place));
    result.covariances.emplace_back(block.topLeftCorner<2, 2>());
  }
  return result;
}

Eigen::MatrixXd joint_landmark_covariance(const PoseGraph& graph) {
  check_graph(graph);
  InverseColumns inverse(graph);
  const int count = static_cast<int>(graph.landmarks.size());
  std::vector<LandmarkId> all;
  for (int i = 0; i < count; ++i) all.push_back(LandmarkId{i});
  const std::vector<int> places = places_of(graph, inverse, all);
  if (!inverse.available()) return {};
  Eigen::MatrixXd joint(2 * count, 2 * count);
  for (int column = 0; column < 2 * count; ++column) {
    const auto& x = inverse.column(places[static_cast<std::size_t>(column / 2)], column % 2);
    for (int i = 0; i < count; ++i) {
      const auto place = static_cast<std::size_t>(places[static_cast<std::size_t>(i)]);
      joint.block<2, 1>(2 * i, column) = x[place].head<2>();
    }
  }
  return 0.5 * (joint + joint.transpose());
}

PairMarginals joint_covariances(const PoseGraph& graph,
                                std::span<const std::pair<NodeId, NodeId>> pairs) {
  check_graph(graph);
  // Each pose's columns are found once, at all poses that it is asked for with.
  std::map<NodeId, std::vector<NodeId>> rows_of;
  for (const auto& [first, second] : pairs) {
    check_node(graph, first);
    check_node(graph, second);
    rows_of[first].push_back(first);
    rows_of[first].push_back(second);
    rows_of[second].push_back(second);
  }
  InverseColumns inverse(graph);
  PairMarginals result;
  result.available = inverse.available();
  if (!result.available) return result;
  std::map<std::pair<NodeId, NodeId>, Eigen::Matrix3d> found;  // column, row
  for (const auto& [column, rows] : rows_of) {
    const std::vector<Eigen::Matrix3d> blocks = inverse.blocks(column, rows);
    for (std::size_t i = 0; i < rows.size(); ++i) found[{column, rows[i]}] = blocks[i];
  }
  for (const auto& [first, second] : pairs) {
    Eigen::Matrix<double, 6, 6> joint;
    joint.topLeftCorner<3, 3>() = symmetric(found[{first, first}]);
    joint.bottomLeftCorner<3, 3>() = found[{first, second}];
    joint.topRightCorner<3, 3>() = found[{first, second}].transpose();
    joint.bottomRightCorner<3, 3>() = symmetric(found[{second, second}]);
    result.covariances.push_back(joint);
  }
  return result;
}

Eigen::Matrix3d relative_covariance(const Pose2& first, const Pose2& second,
                                    const Eigen::Matrix<double, 6, 6>& joint) {
  // The error of an edge that measured nothing: its derivatives are those of the motion itself.
  const EdgeJacobians j = edge_jacobians(RelativePoseEdge{}, first, second);
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian << j.from, j.to;
  return jacobian * joint * jacobian.transpose();
}

}  // namespace loopstone
