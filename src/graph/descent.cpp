#include "graph/descent.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "graph/dogleg.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

/// A cost that steps cannot lower any more in double precision, in squared standard deviations.
constexpr double kNegligibleCost = 1e-18;
constexpr double kFirstDamping = 1e-5;
constexpr double kLeastDamping = 1e-10;  ///< below, Gauss-Newton again
constexpr double kGreatestDamping = 1e12;
/// Steps that Gauss-Newton may spend above its best cost.
constexpr int kPatience = 5;
/// How steadily promises must have shrunk for the next one to be foretold.
constexpr double kFastConvergence = 0.1;

/// By how much the quadratic model says that a (damped) step lowers the cost: -2 g^T dx - dx^T H dx
/// with (H + damping D) dx = -g.
double promised_decrease(const NormalEquations& equations, std::span<const Eigen::Vector3d> step,
                         double damping) {
  double result = 0.0;
  for (std::size_t i = 0; i < step.size(); ++i) {
    const Eigen::Vector3d scaled =
        damping * equations.hessian().diagonal[i].diagonal().cwiseProduct(step[i]);
    result += step[i].dot(scaled - equations.gradient()[i]);
  }
  return result;
}

/// How strongly steps are damped. Nielsen 1999, "Damping parameter in Marquardt's method".
class Damping {
 public:
  explicit Damping(DescentMethod method)
      : may_vanish_(method == DescentMethod::kGaussNewton),
        value_(may_vanish_ ? 0.0 : kFirstDamping) {}

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
    if (value_ < kLeastDamping) value_ = may_vanish_ ? 0.0 : kLeastDamping;
    growth_ = 4.0;
  }

 private:
  bool may_vanish_;
  double value_;
  double growth_ = 4.0;
};

/// One descent: where it is, and the best place it has been.
class Descent {
 public:
  Descent(NormalEquations& equations, BlockCholesky& cholesky, const DescentOptions& options,
          GraphState& state, const StopQuestion& stop)
      : equations_(equations),
        cholesky_(cholesky),
        options_(options),
        state_(state),
        stop_(stop),
        damping_(options.method) {
    step_.resize(equations.gradient().size());
    trial_ = state;
  }

  DescentResult run() {
    result_.initial = equations_.linearise(state_);
    costs_ = result_.initial;
    if (step_.empty()) {
      result_.status = SolveStatus::kConverged;
    } else {
      result_.status = options_.method == DescentMethod::kDogleg ? dogleg() : gauss_newton();
    }
    go_back_to_best();
    result_.final = costs_;
    return result_;
  }

 private:
  SolveStatus gauss_newton() {
    while (result_.iterations < options_.max_iterations && !is_stopped(stop_)) {
      ++result_.iterations;
      if (!cholesky_.factorise(equations_.hessian(), damping_.value())) {
        step_failed();
        if (damping_.exhausted()) return SolveStatus::kNumericalFailure;
        continue;
      }
      find_newton_step();
      const double promised = promised_decrease(equations_, step_, damping_.value());
      if (!std::isfinite(promised)) return SolveStatus::kNumericalFailure;
      const bool last = is_last(promised);
      const double cost = costs_.robust;
      const GraphCosts trial = try_step(last);
      if (trial.robust < cost || may_wander(trial.robust)) {
        take(trial);
        if (trial.robust < cost) damping_.step_succeeded((cost - trial.robust) / promised);
        // A damped step may promise little only because it is short.
        if (last && damping_.value() == 0.0) return SolveStatus::kConverged;
        if (last && options_.method == DescentMethod::kLevenbergMarquardt) {
          if (damping_.value() < 1e-3) return SolveStatus::kConverged;
        }
        if (last) equations_.linearise(state_);
      } else {
        if (last) return SolveStatus::kConverged;
        step_failed();
        if (damping_.exhausted()) return SolveStatus::kNumericalFailure;
      }
    }
    return SolveStatus::kNotConverged;
  }

  SolveStatus dogleg() {
    Dogleg region;
    bool factorised = false;
    while (result_.iterations < options_.max_iterations && !is_stopped(stop_)) {
      ++result_.iterations;
      if (!factorised) {
        // A shade of damping where the measurements leave something open.
        if (!cholesky_.factorise(equations_.hessian(), 0.0) &&
            !cholesky_.factorise(equations_.hessian(), kFirstDamping)) {
          return SolveStatus::kNumericalFailure;
        }
        find_newton_step();
        region.linearise(equations_, step_);
        factorised = true;
      }
      const double promised = region.choose_step(step_);
      if (!std::isfinite(promised)) return SolveStatus::kNumericalFailure;
      const bool last = region.is_newton_step() && is_last(promised);
      const double cost = costs_.robust;
      const GraphCosts trial = try_step(last);
      region.adapt((cost - trial.robust) / promised);
      if (trial.robust < cost) {
        take(trial);
        factorised = false;
      } else if (!last) {
        equations_.linearise(state_);
      }
      if (last) return SolveStatus::kConverged;
      if (region.exhausted()) return SolveStatus::kNumericalFailure;
    }
    return SolveStatus::kNotConverged;
  }

  void find_newton_step() {
    for (std::size_t i = 0; i < step_.size(); ++i) step_[i] = -equations_.gradient()[i];
    cholesky_.solve_in_place(step_);
  }

  /// Whether this step is all there is to gain, or the next one would add next to nothing.
  bool is_last(double promised) {
    const double least = std::max(options_.relative_tolerance * costs_.robust, kNegligibleCost);
    const double shrunk = promised / last_promise_;
    last_promise_ = promised;
    if (promised <= least) return true;
    return damping_.value() == 0.0 && above_best_ == 0 && shrunk <= kFastConvergence &&
           promised * shrunk <= least;
  }

  GraphCosts try_step(bool last) {
    apply_step(state_, equations_, step_, trial_);
    return last ? equations_.costs(trial_) : equations_.linearise(trial_);
  }

  /// Whether to go on from a place that is worse: only undamped, and not for long.
  bool may_wander(double cost) {
    if (damping_.value() != 0.0 || options_.method != DescentMethod::kGaussNewton) return false;
    if (tired_ || !std::isfinite(cost) || above_best_ >= kPatience) return false;
    return true;
  }

  void take(const GraphCosts& trial) {
    if (above_best_ == 0 && trial.robust >= costs_.robust) {
      best_ = state_;
      best_costs_ = costs_;
    }
    if (above_best_ > 0 || trial.robust >= costs_.robust) ++above_best_;
    if (above_best_ > 0 && trial.robust < best_costs_.robust) above_best_ = 0;
    std::swap(state_, trial_);
    costs_ = trial;
  }

  void go_back_to_best() {
    if (above_best_ == 0) return;
    above_best_ = 0;
    state_ = best_;
    costs_ = best_costs_;
  }

  void step_failed() {
    if (above_best_ > 0) tired_ = true;
    go_back_to_best();
    damping_.step_failed();
    last_promise_ = kNoPromise;
    equations_.linearise(state_);
  }

  static constexpr double kNoPromise = 1e-300;

  NormalEquations& equations_;
  BlockCholesky& cholesky_;
  const DescentOptions& options_;
  GraphState& state_;
  const StopQuestion& stop_;
  Damping damping_;
  DescentResult result_;
  GraphCosts costs_;
  GraphState trial_;
  GraphState best_;
  GraphCosts best_costs_;
  int above_best_ = 0;  ///< steps since the cost rose above the best; 0: this is the best
  bool tired_ = false;  ///< a rise led nowhere; no more of them
  double last_promise_ = kNoPromise;
  std::vector<Eigen::Vector3d> step_;
};

}  // namespace

void apply_step(const GraphState& from, const NormalEquations& equations,
                std::span<const Eigen::Vector3d> step, GraphState& to) {
  for (std::size_t i = 0; i < from.poses.size(); ++i) {
    const Pose2& pose = from.poses[i];
    const int place = equations.place_of(i);
    if (place < 0) {
      to.poses[i] = pose;
      continue;
    }
    const Eigen::Vector3d& d = step[static_cast<std::size_t>(place)];
    to.poses[i] = {pose.x + d.x(), pose.y + d.y(), wrap_angle(pose.yaw + d.z())};
  }
  for (std::size_t i = 0; i < from.landmarks.size(); ++i) {
    const int place = equations.place_of_landmark(i);
    to.landmarks[i] = from.landmarks[i];
    if (place >= 0) to.landmarks[i] += step[static_cast<std::size_t>(place)].head<2>();
  }
}

DescentResult descend(NormalEquations& equations, BlockCholesky& cholesky,
                      const DescentOptions& options, GraphState& state, const StopQuestion& stop) {
  return Descent(equations, cholesky, options, state, stop).run();
}

}  // namespace loopstone
