#include "graph/isotropic_descent.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "loopstone/base/hypotenuse.hpp"

namespace loopstone {

namespace {

using Matrix = ConnectionCholesky<RealBlock<3>>;
using Steps = std::vector<Matrix::Values>;

enum class Curvature {
  kNewton,       ///< second derivatives in full
  kGaussNewton,  ///< without those of the residuals: never negative
};

/// Half the Hessian and minus half the gradient of the cost in (x, y, yaw) of each node, by places.
class LocalModel {
 public:
  explicit LocalModel(const IsotropicSystem& system)
      : system_(&system),
        matrix_(system.pattern),
        right_side_(system.problem.nodes),
        scale_(system.problem.nodes) {}

  void linearise(const IsotropicState& state, Curvature curvature, double damping);

  /// The step to the model's minimum; nothing when the matrix is not positive definite.
  [[nodiscard]] bool solve(Steps& steps) {
    if (!matrix_.factorise()) return false;
    steps = right_side_;
    matrix_.solve_in_place(steps);
    return true;
  }
  /// How much lower than the cost at the state the model's minimum lies.
  [[nodiscard]] double promise(const Steps& steps) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < steps.size(); ++i) sum += steps[i].dot(right_side_[i]);
    return sum;
  }

 private:
  void add_edge(std::size_t edge, const IsotropicState& state, Curvature curvature);
  void hold_anchors();

  const IsotropicSystem* system_;
  Matrix matrix_;
  Steps right_side_;
  Steps scale_;  ///< the diagonal without negative curvature: what damping is measured by
};

void LocalModel::linearise(const IsotropicState& state, Curvature curvature, double damping) {
  matrix_.set_zero();
  std::fill(right_side_.begin(), right_side_.end(), Matrix::Values::Zero());
  std::fill(scale_.begin(), scale_.end(), Matrix::Values::Zero());
  for (std::size_t i = 0; i < system_->problem.edges.size(); ++i) add_edge(i, state, curvature);
  hold_anchors();
  if (damping > 0.0) {
    for (std::size_t i = 0; i < system_->problem.nodes; ++i) {
      matrix_.diagonal(static_cast<int>(i)).re.diagonal() += damping * scale_[i];
    }
  }
}

// With q = z_from step, r = t_to - t_from - q and D the angle from z_from turn to z_to, half the
// cost of an edge is
//   tau |r|^2 / 2 + 2 kappa (1 - cos D).
// Turning `from` moves r by -iq, and iq by -q, which gives the second derivatives below.
void LocalModel::add_edge(std::size_t i, const IsotropicState& state, Curvature curvature) {
  const IsotropicEdge& edge = system_->problem.edges[i];
  const double tau = edge.translation_weight;
  const double weight = edge.rotation_weight;
  const Complex q = state.heading[edge.from] * edge.step;
  const Complex r = state.position[edge.to] - state.position[edge.from] - q;
  const Complex d = std::conj(state.heading[edge.from] * edge.turn) * state.heading[edge.to];
  const Eigen::Vector2d turned(-q.imag(), q.real());
  const Eigen::Vector2d residual(r.real(), r.imag());
  const bool newton = curvature == Curvature::kNewton;

  const int from = system_->pattern.place[edge.from];
  const int to = system_->pattern.place[edge.to];
  Matrix::Values& b_from = right_side_[static_cast<std::size_t>(from)];
  Matrix::Values& b_to = right_side_[static_cast<std::size_t>(to)];
  b_from.head<2>() += tau * residual;
  b_to.head<2>() -= tau * residual;
  b_from(2) += tau * residual.dot(turned) + weight * d.imag();
  b_to(2) -= weight * d.imag();
  scale_[static_cast<std::size_t>(from)] += Matrix::Values(tau, tau, tau * std::norm(q) + weight);
  scale_[static_cast<std::size_t>(to)] += Matrix::Values(tau, tau, weight);

  const double rotation = newton ? weight * d.real() : weight;
  const double bend = newton ? q.real() * r.real() + q.imag() * r.imag() : 0.0;
  Eigen::Matrix3d& h_from = matrix_.diagonal(from).re;
  h_from(0, 0) += tau;
  h_from(1, 1) += tau;
  h_from.block<2, 1>(0, 2) += tau * turned;
  h_from.block<1, 2>(2, 0) += tau * turned.transpose();
  h_from(2, 2) += tau * (std::norm(q) + bend) + rotation;
  Eigen::Matrix3d& h_to = matrix_.diagonal(to).re;
  h_to(0, 0) += tau;
  h_to(1, 1) += tau;
  h_to(2, 2) += rotation;
  if (system_->problem.anchored[edge.from] || system_->problem.anchored[edge.to]) return;

  const EdgeBlock& place = system_->blocks[i];
  Eigen::Matrix3d& below = matrix_.below(place.index).re;
  below(0, 0) -= tau;
  below(1, 1) -= tau;
  below(2, 2) -= weight * d.real();
  if (place.to_is_row) {
    below.block<2, 1>(0, 2) -= tau * turned;
  } else {
    below.block<1, 2>(2, 0) -= tau * turned.transpose();
  }
}

void LocalModel::hold_anchors() {
  const IsotropicProblem& problem = system_->problem;
  for (std::size_t node = 0; node < problem.nodes; ++node) {
    const int place = system_->pattern.place[node];
    if (problem.anchored[node]) {
      matrix_.diagonal(place).re.setIdentity();
      right_side_[static_cast<std::size_t>(place)].setZero();
    } else if (node >= problem.headings) {
      matrix_.diagonal(place).re(2, 2) = 1.0;  // landmarks have no heading
    }
  }
}

IsotropicState moved(const IsotropicState& state, const IsotropicSystem& system,
                     const Steps& steps) {
  IsotropicState result = state;
  for (std::size_t i = 0; i < result.heading.size(); ++i) {
    const Matrix::Values& step = steps[static_cast<std::size_t>(system.pattern.place[i])];
    result.position[i] += Complex(step(0), step(1));
    const Complex heading = result.heading[i] * Complex(std::cos(step(2)), std::sin(step(2)));
    result.heading[i] = heading / hypotenuse(heading.real(), heading.imag());
  }
  return result;
}

}  // namespace

IsotropicDescentResult descend_isotropic(const IsotropicSystem& system, IsotropicState start,
                                         const IsotropicDescentOptions& options,
                                         const StopQuestion& stop) {
  constexpr double kFirstDamping = 1e-5;
  constexpr double kMostDamping = 1e10;
  constexpr double kNegligibleCost = 1e-20;
  constexpr double kWorthwhile = 0.9;  // of the cost: what a Gauss-Newton step has to get below
  IsotropicDescentResult result;
  result.state = std::move(start);
  result.cost = isotropic_cost(system.problem, result.state);
  LocalModel model(system);
  Steps steps;
  double promised = 0.0;
  // Whether a step leads below the cost times the share; if so it is taken.
  const auto step_down = [&](Curvature curvature, double damping, double share) {
    ++result.iterations;
    model.linearise(result.state, curvature, damping);
    if (!model.solve(steps)) return false;
    promised = model.promise(steps);
    IsotropicState trial = moved(result.state, system, steps);
    const double cost = isotropic_cost(system.problem, trial);
    if (!(cost < share * result.cost)) return false;
    result.state = std::move(trial);
    result.cost = cost;
    return true;
  };

  double damping = 0.0;
  bool far = true;  // where Gauss-Newton, which sees no negative curvature, leads down fast
  while (result.iterations < options.max_iterations && damping < kMostDamping &&
         !is_stopped(stop)) {
    const double negligible = std::max(options.relative_tolerance * result.cost, kNegligibleCost);
    promised = 2.0 * negligible + 1.0;
    const bool down = step_down(Curvature::kNewton, damping, 1.0);
    if (promised <= negligible && (damping == 0.0 || !down)) {
      result.converged = true;
      break;
    }
    if (down) {
      damping = damping > kFirstDamping ? 0.4 * damping : 0.0;
    } else if (far) {
      far = step_down(Curvature::kGaussNewton, 0.0, kWorthwhile);
    } else {
      damping = std::max(3.0 * damping, kFirstDamping);
    }
  }
  return result;
}

}  // namespace loopstone
