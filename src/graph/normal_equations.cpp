#include "graph/normal_equations.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace loopstone {

namespace {

constexpr int kFixed = -1;

struct FreePoses {
  std::vector<int> place;  ///< before ordering; kFixed for the others
  int count = 0;
};

FreePoses number_free_poses(const std::vector<bool>& fixed) {
  FreePoses result;
  result.place.reserve(fixed.size());
  for (const bool is_fixed : fixed) result.place.push_back(is_fixed ? kFixed : result.count++);
  return result;
}

int block_index(const BlockMatrix& matrix, int a, int b) {
  const auto column = static_cast<std::size_t>(std::min(a, b));
  const auto begin = matrix.rows.begin() + matrix.column_start[column];
  const auto end = matrix.rows.begin() + matrix.column_start[column + 1];
  return static_cast<int>(std::lower_bound(begin, end, std::max(a, b)) - matrix.rows.begin());
}

}  // namespace

NormalEquations::NormalEquations(const PoseGraph& graph, const std::vector<bool>& fixed,
                                 const RobustPolicy& policy)
    : policy_(policy) {
  FreePoses free = number_free_poses(fixed);
  place_ = std::move(free.place);
  std::vector<std::pair<int, int>> pairs;
  pairs.reserve(graph.edges.size());
  const auto places = [this](const RelativePoseEdge& edge) {
    return std::pair{place_[static_cast<std::size_t>(edge.from.index)],
                     place_[static_cast<std::size_t>(edge.to.index)]};
  };
  for (const RelativePoseEdge& edge : graph.edges) {
    const auto pair = places(edge);
    if (pair.first != kFixed && pair.second != kFixed) pairs.push_back(pair);
  }
  const std::vector<int> order = fill_reducing_order(free.count, pairs);
  for (int& place : place_) {
    if (place != kFixed) place = order[static_cast<std::size_t>(place)];
  }
  for (auto& [a, b] : pairs) {
    a = order[static_cast<std::size_t>(a)];
    b = order[static_cast<std::size_t>(b)];
  }
  hessian_ = block_matrix(free.count, std::move(pairs));
  gradient_.resize(static_cast<std::size_t>(free.count));

  terms_.reserve(graph.edges.size());
  for (const RelativePoseEdge& edge : graph.edges) {
    const auto [from, to] = places(edge);
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    turn.topLeftCorner<2, 2>() = edge.from_T_to.rotation();
    terms_.push_back({static_cast<std::size_t>(edge.from.index),
                      static_cast<std::size_t>(edge.to.index), from, to,
                      from != kFixed && to != kFixed ? block_index(hessian_, from, to) : kFixed,
                      edge.from_T_to, turn * edge.information * turn.transpose(), edge.kind});
  }
}

Eigen::Vector3d NormalEquations::error_of(const Term& term, std::span<const Pose2> poses) const {
  const Pose2& from = poses[term.from];
  const Pose2& to = poses[term.to];
  const double c = std::cos(from.yaw);
  const double s = std::sin(from.yaw);
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  return {c * dx + s * dy - term.from_T_to.x, -s * dx + c * dy - term.from_T_to.y,
          wrap_angle(to.yaw - from.yaw - term.from_T_to.yaw)};
}

GraphCosts NormalEquations::costs(std::span<const Pose2> poses) const {
  GraphCosts result;
  for (const Term& term : terms_) {
    const Eigen::Vector3d error = error_of(term, poses);
    const double chi2 = error.dot(term.information * error);
    result.plain += chi2;
    result.robust += policy_.of(term.kind, chi2).cost;
  }
  return result;
}

std::vector<double> NormalEquations::edge_weights(std::span<const Pose2> poses) const {
  std::vector<double> weights;
  weights.reserve(terms_.size());
  for (const Term& term : terms_) {
    const Eigen::Vector3d error = error_of(term, poses);
    weights.push_back(policy_.of(term.kind, error.dot(term.information * error)).weight);
  }
  return weights;
}

void NormalEquations::linearise(std::span<const Pose2> poses) {
  for (Eigen::Matrix3d& block : hessian_.diagonal) block.setZero();
  for (Eigen::Matrix3d& block : hessian_.below) block.setZero();
  for (Eigen::Vector3d& block : gradient_) block.setZero();
  for (const Term& term : terms_) {
    const Pose2& from = poses[term.from];
    const Eigen::Vector3d error = error_of(term, poses);
    const double chi2 = error.dot(term.information * error);
    const double weight = policy_.of(term.kind, chi2).weight;

    // With Rz left out, J_to = diag(Rf^T, 1) and J_from = -J_to T, where T = [1 0 -dy; 0 1 dx; 0 0 1] moves a turn of
    // the first pose to the second; so B = J_to^T information J_to gives all four blocks.
    Eigen::Matrix3d jacobian_to = Eigen::Matrix3d::Identity();
    jacobian_to.topLeftCorner<2, 2>() = from.rotation().transpose();
    const Eigen::Matrix3d weighted = weight * (jacobian_to.transpose() * term.information);
    const Eigen::Matrix3d b = weighted * jacobian_to;
    const Eigen::Vector3d g = weighted * error;
    const double dx = poses[term.to].x - from.x;
    const double dy = poses[term.to].y - from.y;
    // T^T B and T^T g: only the last row changes.
    Eigen::Matrix3d turned = b;
    turned.row(2) += dx * b.row(1) - dy * b.row(0);

    if (term.place_to != kFixed) {
      const auto to = static_cast<std::size_t>(term.place_to);
      hessian_.diagonal[to] += b;
      gradient_[to] += g;
    }
    if (term.place_from != kFixed) {
      const auto at = static_cast<std::size_t>(term.place_from);
      Eigen::Matrix3d both = turned;
      both.col(2) += dx * turned.col(1) - dy * turned.col(0);
      hessian_.diagonal[at] += both;
      gradient_[at] -= Eigen::Vector3d(g.x(), g.y(), g.z() + dx * g.y() - dy * g.x());
    }
    if (term.below != kFixed) {
      // H(from, to) = -T^T B; below the diagonal stands (row, column) with row > column.
      Eigen::Matrix3d& block = hessian_.below[static_cast<std::size_t>(term.below)];
      if (term.place_from > term.place_to) {
        block -= turned;
      } else {
        block -= turned.transpose();
      }
    }
  }
}

}  // namespace loopstone
