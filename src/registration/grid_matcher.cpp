#include "loopstone/registration/grid_matcher.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/geometry/rigid_motion.hpp"
#include "registration/line_equations.hpp"
#include "registration/open_translation.hpp"

namespace loopstone {

namespace {

constexpr int kMinPairs = 10;
/// A step smaller than this ends the finest level: the next one would be a few times smaller still,
/// less than what the grid itself is wrong by.
constexpr double kStepM = 1e-3;
constexpr double kStepRad = 2e-4;
/// On coarser levels so many times as long a step does.
constexpr double kCoarseSteps = 10.0;
/// Information [1/m^2, 1/rad^2] that stands in for none, so that matrices can be inverted.
constexpr double kDamping = 1e-3;
/// What no number of points averages away: the grid's own error.
constexpr double kFloorM = 0.003;
constexpr double kFloorRad = 0.001;

/// Normal equations of one Gauss-Newton step, with what they say about the fit.
struct Linearisation {
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  double squared_sum = 0.0;
  double weight_sum = 0.0;
  double explained = 0.0;  // weight of the points near a surface
  double total = 0.0;      // weight of all points
  int pairs = 0;
};

Linearisation linearise(std::span<const SurfacePoint> source, const SurfaceGrid& target,
                        std::size_t level, const Pose2& pose, double kernel_width_m) {
  Linearisation sum;
  const double cosine = std::cos(pose.yaw);
  const double sine = std::sin(pose.yaw);
  const double inverse_width2 = 1.0 / (kernel_width_m * kernel_width_m);
  LineEquations equations;
  for (const SurfacePoint& surface : source) {
    sum.total += surface.weight;
    const double px = surface.position.x();
    const double py = surface.position.y();
    const double arm_x = cosine * px - sine * py;
    const double arm_y = sine * px + cosine * py;
    const double nx = surface.normal.x();
    const double ny = surface.normal.y();
    const Eigen::Vector2d point(arm_x + pose.x, arm_y + pose.y);
    const auto line =
        target.line_near(level, point, {cosine * nx - sine * ny, sine * nx + cosine * ny});
    if (!line) continue;
    const double residual = line->normal.dot(point - line->point);
    const double scaled2 = residual * residual * inverse_width2;
    const double weight = surface.weight / (1.0 + scaled2);  // Cauchy
    equations.add(line->normal.x(), line->normal.y(), arm_x, arm_y, residual, weight);
    sum.squared_sum += weight * residual * residual;
    sum.weight_sum += weight;
    if (scaled2 < 4.0) sum.explained += surface.weight;
    ++sum.pairs;
  }
  sum.hessian = equations.hessian();
  sum.gradient = equations.gradient();
  return sum;
}

/// Takes out of the normal equations the direction of translation that the points leave open, if
/// there is one. Then only a prior holds the pose there.
bool remove_unobserved(Linearisation& sum) {
  const auto open = open_translation(sum.hessian);
  if (!open) return false;
  if (!(open->information > 0.0)) return true;
  sum.gradient -= open->along * (open->motion.dot(sum.gradient) / open->information);
  sum.hessian -= open->along * open->along.transpose() / open->information;
  return true;
}

/// What a step is found from, points and prior together.
struct StepEquations {
  Eigen::Matrix3d pull;  ///< what moves the pose
  Eigen::Vector3d gradient;
  Eigen::Matrix3d knowledge;  ///< what is known of the pose in the end
  bool degenerate = false;    ///< the points leave a direction of translation open
};

StepEquations step_equations(const Linearisation& points, const Pose2& pose,
                             const std::optional<PosePrior2>& prior, double inverse_sigma2) {
  Linearisation observed = points;
  StepEquations equations;
  equations.degenerate = remove_unobserved(observed);
  // What the points say along an open direction may move the pose, but is no knowledge.
  const bool held = !prior || prior->holds_unobserved;
  const Linearisation& pulling = held ? observed : points;
  equations.pull = pulling.hessian * inverse_sigma2;
  equations.gradient = pulling.gradient * inverse_sigma2;
  equations.knowledge = observed.hessian * inverse_sigma2;
  if (prior) {
    equations.pull += prior->information;
    equations.knowledge += prior->information;
    equations.gradient +=
        prior->information * RigidMotion<2>::difference(pose, prior->target_T_source);
  }
  return equations;
}

Eigen::Vector3d step_of(const StepEquations& equations) {
  // A trace of damping keeps an unobserved direction where it is.
  Eigen::Matrix3d damped = equations.pull;
  damped.diagonal() += 1e-6 * equations.pull.diagonal() + Eigen::Vector3d::Constant(kDamping);
  return -solve_symmetric(damped, equations.gradient);
}

/// Where the descent stands, with what its last step was found from.
struct Descent {
  Pose2 pose;
  Linearisation points{};
  Eigen::Matrix3d knowledge = Eigen::Matrix3d::Zero();
  int iterations = 0;
  bool converged = false;
  bool degenerate = false;
};

/// Gauss-Newton on one level. False when too few points find a surface there.
bool descend(Descent& at, std::span<const SurfacePoint> source, const SurfaceGrid& target,
             std::size_t level, const std::optional<PosePrior2>& prior,
             const GridMatchOptions& options) {
  const double width = options.kernel_width_m * target.resolution_m(level) / target.resolution_m(0);
  const double inverse_sigma2 = 1.0 / (options.residual_sigma_m * options.residual_sigma_m);
  const double enough = level == 0 ? 1.0 : kCoarseSteps;
  at.converged = false;
  for (int iteration = 0; iteration < options.max_iterations && !at.converged; ++iteration) {
    at.points = linearise(source, target, level, at.pose, width);
    ++at.iterations;
    if (at.points.pairs < kMinPairs) return false;
    const StepEquations equations = step_equations(at.points, at.pose, prior, inverse_sigma2);
    at.knowledge = equations.knowledge;
    at.degenerate = equations.degenerate;
    const Eigen::Vector3d step = step_of(equations);
    if (!step.allFinite()) break;
    at.pose = RigidMotion<2>::moved(at.pose, step);
    at.converged =
        step.head<2>().norm() < enough * kStepM && std::abs(step.z()) < enough * kStepRad;
  }
  return true;
}

Eigen::Matrix3d covariance_of(const Eigen::Matrix3d& knowledge) {
  Eigen::Matrix3d invertible = knowledge;
  invertible.diagonal() += Eigen::Vector3d::Constant(kDamping);
  Eigen::Matrix3d covariance = inverse_symmetric(invertible);
  covariance.diagonal() +=
      Eigen::Vector3d(kFloorM * kFloorM, kFloorM * kFloorM, kFloorRad * kFloorRad);
  return covariance;
}

MatchStatus status_of(const Descent& descent) {
  if (descent.degenerate) return MatchStatus::kDegenerate;
  return descent.converged ? MatchStatus::kConverged : MatchStatus::kNotConverged;
}

/// How well the pose fits, from the points of the last step.
MatchResult judged(const Descent& descent, std::size_t source_size) {
  const Linearisation& points = descent.points;
  const auto share = [](double part, double whole) { return whole > 0.0 ? part / whole : 0.0; };
  return {.target_T_source = descent.pose,
          .covariance = covariance_of(descent.knowledge),
          .rmse_m = std::sqrt(share(points.squared_sum, points.weight_sum)),
          .inlier_fraction = share(points.pairs, static_cast<double>(source_size)),
          .pairs = points.pairs,
          .iterations = descent.iterations,
          .status = status_of(descent),
          .score = share(points.explained, points.total)};
}

}  // namespace

MatchResult match_to_grid(std::span<const SurfacePoint> source, const SurfaceGrid& target,
                          const Pose2& guess, const std::optional<PosePrior2>& prior,
                          const GridMatchOptions& options, std::size_t coarsest_level) {
  Descent descent{.pose = guess};
  // Coarser levels only lead to where the finest one starts; one that finds too little leads
  // nowhere.
  for (std::size_t level = std::min(coarsest_level, target.level_count() - 1); level > 0; --level) {
    (void)descend(descent, source, target, level, prior, options);
  }
  if (!descend(descent, source, target, 0, prior, options)) {
    return {.target_T_source = guess,
            .iterations = descent.iterations,
            .status = MatchStatus::kTooFewPairs};
  }
  return judged(descent, source.size());
}

}  // namespace loopstone
