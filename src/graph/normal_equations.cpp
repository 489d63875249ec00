#include "graph/normal_equations.hpp"

#include <algorithm>
#include <cmath>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

constexpr int kFixed = -1;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

int block_index(const BlockMatrix& matrix, int a, int b) {
  const auto column = at(std::min(a, b));
  const auto begin = matrix.rows.begin() + matrix.column_start[column];
  const auto end = matrix.rows.begin() + matrix.column_start[column + 1];
  return static_cast<int>(std::lower_bound(begin, end, std::max(a, b)) - matrix.rows.begin());
}

/// For a sum of three angles in (-pi, pi].
double wrapped(double angle) {
  while (angle > kPi) angle -= 2.0 * kPi;
  while (angle <= -kPi) angle += 2.0 * kPi;
  return angle;
}

Eigen::Matrix3d turned(const Eigen::Matrix3d& information, const Pose2& measured) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = measured.rotation();
  return turn * information * turn.transpose();
}

}  // namespace

NormalEquations::NormalEquations(const PoseGraph& graph, const std::vector<bool>& fixed,
                                 const RobustPolicy& policy)
    : policy_(policy), pose_count_(graph.poses.size()) {
  build_pattern(graph, fixed);
  const auto below = [this](int a, int b) {
    return a == kFixed || b == kFixed ? kFixed : block_index(hessian_, a, b);
  };
  terms_.reserve(graph.edges.size());
  for (const RelativePoseEdge& edge : graph.edges) {
    const int from = place_[at(edge.from.index)];
    const int to = place_[at(edge.to.index)];
    const Eigen::Matrix3d i = turned(edge.information, edge.from_T_to);
    terms_.push_back({edge.from.index,
                      edge.to.index,
                      from,
                      to,
                      below(from, to),
                      edge.kind == EdgeKind::kLoopClosure,
                      edge.from_T_to.x,
                      edge.from_T_to.y,
                      wrap_angle(edge.from_T_to.yaw),
                      1.0,
                      {i(0, 0), i(0, 1), i(0, 2), i(1, 1), i(1, 2), i(2, 2)}});
  }
  for (const LandmarkEdge& edge : graph.landmark_edges) {
    const int from = place_[at(edge.from.index)];
    const int to = place_[pose_count_ + at(edge.landmark.index)];
    const Eigen::Matrix2d& i = edge.information;
    landmark_terms_.push_back({edge.from.index,
                               edge.landmark.index,
                               from,
                               to,
                               below(from, to),
                               false,
                               edge.point_in_from.x(),
                               edge.point_in_from.y(),
                               0.0,
                               1.0,
                               {i(0, 0), i(0, 1), 0.0, i(1, 1), 0.0, 0.0}});
  }
  for (const PosePrior& prior : graph.priors) {
    prior_terms_.push_back({prior.node.index, place_[at(prior.node.index)], prior.map_T_node,
                            turned(prior.information, prior.map_T_node)});
  }
}

void NormalEquations::build_pattern(const PoseGraph& graph, const std::vector<bool>& fixed) {
  std::vector<bool> seen(graph.landmarks.size(), false);
  for (const LandmarkEdge& edge : graph.landmark_edges) seen[at(edge.landmark.index)] = true;
  int count = 0;
  for (const bool is_fixed : fixed) place_.push_back(is_fixed ? kFixed : count++);
  for (const bool is_seen : seen) place_.push_back(is_seen ? count++ : kFixed);

  std::vector<std::pair<int, int>> pairs;
  pairs.reserve(graph.edges.size() + graph.landmark_edges.size());
  const auto add_pair = [&](int a, int b) {
    if (a != kFixed && b != kFixed) pairs.emplace_back(a, b);
  };
  for (const RelativePoseEdge& edge : graph.edges) {
    add_pair(place_[at(edge.from.index)], place_[at(edge.to.index)]);
  }
  for (const LandmarkEdge& edge : graph.landmark_edges) {
    add_pair(place_[at(edge.from.index)], place_[pose_count_ + at(edge.landmark.index)]);
  }
  const std::vector<int> order = fill_reducing_order(count, pairs);
  for (int& place : place_) {
    if (place != kFixed) place = order[at(place)];
  }
  for (auto& [a, b] : pairs) {
    a = order[at(a)];
    b = order[at(b)];
  }
  hessian_ = block_matrix(count, std::move(pairs));
  gradient_.resize(at(count));
}

void NormalEquations::set_edge_scales(std::span<const double> scales) {
  for (std::size_t i = 0; i < terms_.size(); ++i) terms_[i].scale = scales[i];
}

void NormalEquations::find_sines(const std::vector<Pose2>& poses) {
  cos_sin_.resize(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    cos_sin_[i] = {std::cos(poses[i].yaw), std::sin(poses[i].yaw)};
  }
}

NormalEquations::Error NormalEquations::error_of(const Term& term,
                                                 const std::vector<Pose2>& poses) const {
  // Rz e: the error before it is rotated to the measurement's axes.
  const Pose2& from = poses[at(term.from)];
  const Pose2& to = poses[at(term.to)];
  const auto [c, s] = cos_sin_[at(term.from)];
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  Error e;
  e.x = c * dx + s * dy - term.x;
  e.y = -s * dx + c * dy - term.y;
  e.yaw = wrapped(to.yaw - from.yaw - term.yaw);
  const auto& i = term.information;
  e.wx = i[0] * e.x + i[1] * e.y + i[2] * e.yaw;
  e.wy = i[1] * e.x + i[3] * e.y + i[4] * e.yaw;
  e.wyaw = i[2] * e.x + i[4] * e.y + i[5] * e.yaw;
  e.chi2 = term.scale * (e.x * e.wx + e.y * e.wy + e.yaw * e.wyaw);
  return e;
}

NormalEquations::Error NormalEquations::landmark_error_of(const Term& term,
                                                          const GraphState& state) const {
  const Pose2& from = state.poses[at(term.from)];
  const Eigen::Vector2d& landmark = state.landmarks[at(term.to)];
  const auto [c, s] = cos_sin_[at(term.from)];
  const double dx = landmark.x() - from.x;
  const double dy = landmark.y() - from.y;
  Error e;
  e.x = c * dx + s * dy - term.x;
  e.y = -s * dx + c * dy - term.y;
  e.wx = term.information[0] * e.x + term.information[1] * e.y;
  e.wy = term.information[1] * e.x + term.information[3] * e.y;
  e.chi2 = e.x * e.wx + e.y * e.wy;
  return e;
}

template <typename Edge, typename Landmark, typename Prior>
void NormalEquations::for_each(const GraphState& state, Edge&& visit_edge,
                               Landmark&& visit_landmark_edge, Prior&& visit_prior) {
  find_sines(state.poses);
  for (const Term& term : terms_) visit_edge(term, error_of(term, state.poses));
  for (const Term& term : landmark_terms_) {
    visit_landmark_edge(term, landmark_error_of(term, state));
  }
  for (const PriorTerm& term : prior_terms_) {
    const Pose2& pose = state.poses[at(term.node)];
    const Eigen::Vector3d error(pose.x - term.map_T_node.x, pose.y - term.map_T_node.y,
                                wrap_angle(pose.yaw - term.map_T_node.yaw));
    visit_prior(term, error, error.dot(term.information * error));
  }
}

GraphCosts NormalEquations::costs(const GraphState& state) {
  GraphCosts result;
  const auto count = [&](bool closure, double chi2) {
    result.plain += chi2;
    result.robust += policy_.of(closure, chi2).cost;
  };
  for_each(
      state, [&](const Term& term, const Error& e) { count(term.closure, e.chi2); },
      [&](const Term&, const Error& e) { count(false, e.chi2); },
      [&](const PriorTerm&, const Eigen::Vector3d&, double chi2) { count(false, chi2); });
  return result;
}

GraphWeights NormalEquations::weights(const GraphState& state) {
  GraphWeights result;
  result.edges.reserve(terms_.size());
  for_each(
      state,
      [&](const Term& term, const Error& e) {
        result.edges.push_back(term.scale * policy_.of(term.closure, e.chi2).weight);
      },
      [&](const Term&, const Error& e) {
        result.landmark_edges.push_back(policy_.of(false, e.chi2).weight);
      },
      [&](const PriorTerm&, const Eigen::Vector3d&, double chi2) {
        result.priors.push_back(policy_.of(false, chi2).weight);
      });
  return result;
}

/// With Rz left out, J_to = diag(Rf^T, 1) and J_from = -J_to T, where T = [1 0 -dy; 0 1 dx; 0 0 1]
/// moves a turn of the first pose to the second; so B = J_to^T information J_to gives all four
/// blocks. A landmark has no yaw: the third row and column of its B are zero, and the same holds.
// Over 60 lines: straight arithmetic that the four blocks share, in the innermost loop of every
// solution.
void NormalEquations::add(const Term& term, const Error& e, double weight, double dx, double dy) {
  const auto [c, s] = cos_sin_[at(term.from)];
  const auto& i = term.information;
  // Columns of information * Rf^T, then Rf times them.
  const double m00 = i[0] * c - i[1] * s;
  const double m01 = i[0] * s + i[1] * c;
  const double m10 = i[1] * c - i[3] * s;
  const double m11 = i[1] * s + i[3] * c;
  const double b00 = weight * (c * m00 - s * m10);
  const double b01 = weight * (c * m01 - s * m11);
  const double b11 = weight * (s * m01 + c * m11);
  const double b02 = weight * (c * i[2] - s * i[4]);
  const double b12 = weight * (s * i[2] + c * i[4]);
  const double b22 = weight * i[5];
  const double gx = weight * (c * e.wx - s * e.wy);
  const double gy = weight * (s * e.wx + c * e.wy);
  const double gyaw = weight * e.wyaw;

  if (term.place_to != kFixed) {
    double* h = hessian_.diagonal[at(term.place_to)].data();
    h[0] += b00;
    h[1] += b01;
    h[2] += b02;
    h[3] += b01;
    h[4] += b11;
    h[5] += b12;
    h[6] += b02;
    h[7] += b12;
    h[8] += b22;
    double* g = gradient_[at(term.place_to)].data();
    g[0] += gx;
    g[1] += gy;
    g[2] += gyaw;
  }
  if (term.place_from == kFixed) return;
  // T^T B: only the last row changes.
  const double t0 = b02 + dx * b01 - dy * b00;
  const double t1 = b12 + dx * b11 - dy * b01;
  const double t2 = b22 + dx * b12 - dy * b02;
  double* h = hessian_.diagonal[at(term.place_from)].data();
  h[0] += b00;
  h[1] += b01;
  h[2] += t0;
  h[3] += b01;
  h[4] += b11;
  h[5] += t1;
  h[6] += t0;
  h[7] += t1;
  h[8] += t2 + dx * t1 - dy * t0;
  double* g = gradient_[at(term.place_from)].data();
  g[0] -= gx;
  g[1] -= gy;
  g[2] -= gyaw + dx * gy - dy * gx;
  if (term.below == kFixed) return;
  // H(from, to) = -T^T B; below the diagonal stands (row, column) with row > column.
  double* block = hessian_.below[at(term.below)].data();
  const bool upright = term.place_from > term.place_to;
  block[0] -= b00;
  block[1] -= b01;
  block[2] -= upright ? t0 : b02;
  block[3] -= b01;
  block[4] -= b11;
  block[5] -= upright ? t1 : b12;
  block[6] -= upright ? b02 : t0;
  block[7] -= upright ? b12 : t1;
  block[8] -= t2;
}

void NormalEquations::add_prior(const PriorTerm& term, const Eigen::Vector3d& error,
                                double weight) {
  if (term.place == kFixed) return;
  hessian_.diagonal[at(term.place)] += weight * term.information;
  gradient_[at(term.place)] += weight * (term.information * error);
}

GraphCosts NormalEquations::linearise(const GraphState& state) {
  for (Eigen::Matrix3d& block : hessian_.diagonal) block.setZero();
  for (Eigen::Matrix3d& block : hessian_.below) block.setZero();
  for (Eigen::Vector3d& block : gradient_) block.setZero();
  for (std::size_t i = pose_count_; i < place_.size(); ++i) {
    if (place_[i] != kFixed) hessian_.diagonal[at(place_[i])](2, 2) = 1.0;
  }
  GraphCosts result;
  const auto count = [&](bool closure, double chi2) {
    const RobustValue value = policy_.of(closure, chi2);
    result.plain += chi2;
    result.robust += value.cost;
    return value.weight;
  };
  for_each(
      state,
      [&](const Term& term, const Error& e) {
        const Pose2& from = state.poses[at(term.from)];
        const Pose2& to = state.poses[at(term.to)];
        add(term, e, term.scale * count(term.closure, e.chi2), to.x - from.x, to.y - from.y);
      },
      [&](const Term& term, const Error& e) {
        const Pose2& from = state.poses[at(term.from)];
        const Eigen::Vector2d& to = state.landmarks[at(term.to)];
        add(term, e, count(false, e.chi2), to.x() - from.x, to.y() - from.y);
      },
      [&](const PriorTerm& term, const Eigen::Vector3d& error, double chi2) {
        add_prior(term, error, count(false, chi2));
      });
  return result;
}

}  // namespace loopstone
