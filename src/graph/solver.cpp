#include "loopstone/graph/solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "graph/block_cholesky.hpp"
#include "graph/normal_equations.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {

namespace {

/// A cost that steps cannot lower any more in double precision, in squared standard deviations.
constexpr double kNegligibleCost = 1e-18;
constexpr double kFirstDamping = 1e-5;
constexpr double kLeastDamping = 1e-10;  ///< below, Gauss-Newton again
constexpr double kGreatestDamping = 1e12;

/// The first pose of each component.
std::vector<bool> gauge_of(const GraphComponents& components) {
  std::vector<bool> fixed(components.of_node.size(), false);
  std::vector<bool> has_gauge(static_cast<std::size_t>(components.count), false);
  for (std::size_t node = 0; node < fixed.size(); ++node) {
    const auto component = static_cast<std::size_t>(components.of_node[node]);
    fixed[node] = !has_gauge[component];
    has_gauge[component] = true;
  }
  return fixed;
}

std::vector<Pose2> moved(const std::vector<Pose2>& poses, const NormalEquations& equations,
                         const std::vector<Eigen::Vector3d>& steps) {
  std::vector<Pose2> result = poses;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const int place = equations.place_of(i);
    if (place < 0) continue;
    const Eigen::Vector3d& step = steps[static_cast<std::size_t>(place)];
    result[i] = {poses[i].x + step.x(), poses[i].y + step.y(), wrap_angle(poses[i].yaw + step.z())};
  }
  return result;
}

/// By how much the quadratic model says that a (damped) step lowers the cost: -2 g^T dx - dx^T H dx with
/// (H + damping D) dx = -g.
double promised_decrease(const NormalEquations& equations,
                         const std::vector<Eigen::Vector3d>& steps, double damping) {
  double result = 0.0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Eigen::Vector3d scaled =
        damping * equations.hessian().diagonal[i].diagonal().cwiseProduct(steps[i]);
    result += steps[i].dot(scaled - equations.gradient()[i]);
  }
  return result;
}

/// How strongly steps are damped: not at all until one fails. Nielsen 1999, "Damping parameter in Marquardt's method".
class Damping {
 public:
  [[nodiscard]] double value() const { return value_; }
  [[nodiscard]] bool exhausted() const { return value_ > kGreatestDamping; }

  void step_failed() {
    value_ = value_ == 0.0 ? kFirstDamping : value_ * growth_;
    growth_ *= 2.0;
  }
  /// \param gain  decrease over promised decrease
  void step_succeeded(double gain) {
    const double bend = 2.0 * gain - 1.0;
    value_ *= std::max(1.0 / 10.0, 1.0 - bend * bend * bend);
    if (value_ < kLeastDamping) value_ = 0.0;
    growth_ = 4.0;
  }

 private:
  double value_ = 0.0;
  double growth_ = 4.0;
};

/// Lowers the cost of result.poses until nothing is left to gain.
SolveStatus descend(NormalEquations& equations, const SolverOptions& options, SolveResult& result) {
  BlockCholesky cholesky(equations.hessian());
  Damping damping;
  double cost = result.robust_cost_initial;
  bool linearised = false;
  while (result.iterations < options.max_iterations) {
    ++result.iterations;
    if (!linearised) equations.linearise(result.poses);
    linearised = true;
    if (!cholesky.factorise(equations.hessian(), damping.value())) {
      damping.step_failed();
      if (damping.exhausted()) return SolveStatus::kNumericalFailure;
      continue;
    }
    std::vector<Eigen::Vector3d> steps = cholesky.solve(equations.gradient());
    for (Eigen::Vector3d& step : steps) step = -step;
    const double promised = promised_decrease(equations, steps, damping.value());
    if (!std::isfinite(promised)) return SolveStatus::kNumericalFailure;
    const bool last = promised <= std::max(options.relative_tolerance * cost, kNegligibleCost);

    std::vector<Pose2> trial = moved(result.poses, equations, steps);
    const double trial_cost = equations.costs(trial).robust;
    if (trial_cost < cost) {
      result.poses = std::move(trial);
      damping.step_succeeded((cost - trial_cost) / promised);
      cost = trial_cost;
      linearised = false;
    } else {
      damping.step_failed();
    }
    // A damped step may promise little only because it is short.
    if (last && (trial_cost >= cost || damping.value() == 0.0)) return SolveStatus::kConverged;
    if (damping.exhausted()) return SolveStatus::kNumericalFailure;
  }
  return SolveStatus::kNotConverged;
}

}  // namespace

std::string_view to_string(SolveStatus status) {
  switch (status) {
    case SolveStatus::kConverged:
      return "converged";
    case SolveStatus::kNotConverged:
      return "not_converged";
    case SolveStatus::kNumericalFailure:
      return "numerical_failure";
    case SolveStatus::kDisconnected:
      return "disconnected";
  }
  return "unknown";
}

SolveResult optimize(const PoseGraph& graph, const SolverOptions& options) {
  check_graph(graph);
  const RobustPolicy policy{robust_kernel_from(options.robust_kernel), options.robust_width,
                            options.robust_everywhere};
  const GraphComponents components = connected_components(graph);
  NormalEquations equations(graph, gauge_of(components), policy);

  SolveResult result;
  result.poses = graph.poses;
  result.components = components.count;
  const GraphCosts initial = equations.costs(result.poses);
  result.cost_initial = initial.plain;
  result.robust_cost_initial = initial.robust;
  result.status =
      graph.edges.empty() ? SolveStatus::kConverged : descend(equations, options, result);
  if (components.count > 1) result.status = SolveStatus::kDisconnected;
  const GraphCosts final = equations.costs(result.poses);
  result.cost = final.plain;
  result.robust_cost = final.robust;
  result.edge_weights = equations.edge_weights(result.poses);
  return result;
}

}  // namespace loopstone
