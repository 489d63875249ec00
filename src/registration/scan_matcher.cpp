#include "loopstone/registration/scan_matcher.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/geometry/angle.hpp"
#include "registration/observability.hpp"
#include "registration/scan_fit.hpp"
#include "registration/window_search.hpp"

namespace loopstone {

namespace {

constexpr int kMinPairs = 8;
/// A step smaller than this is the last one.
constexpr double kStepM = 5e-5;
constexpr double kStepRad = 1e-5;
/// Pairs may change to and fro for ever: after so many steps, that much longer ones are good
/// enough.
constexpr int kPatientSteps = 10;
constexpr double kFlipSlack = 20.0;
/// Candidates are compared by this many surfaces of each scan.
constexpr std::size_t kLookPoints = 60;
/// How a candidate of the coarse search is pulled in: widths of the kernel, one a step.
constexpr double kPullWidthsM[] = {0.2, 0.15, 0.1, 0.05};
constexpr double kLookWidthM = 0.05;
/// Both scans explain each other so well that no other candidate needs a look.
constexpr double kSureExplained = 0.95;
constexpr double kSureVisible = 0.6;
/// Each scan has to explain this share of what it could see of the other, and this share of the
/// whole other.
constexpr double kLeastOfVisible = 0.8;
constexpr double kLeastOfWhole = 0.45;

struct Look {
  Pose2 target_T_source;
  double rank = -4.0;
  bool sure = false;
};

std::size_t stride_of(const ScanView& view) {
  return std::max<std::size_t>(1, view.surfaces.size() / kLookPoints);
}

/// One Gauss-Newton step; nothing when the equations can't be solved.
std::optional<Eigen::Vector3d> solve(const ScanEquations& equations) {
  if (equations.pairs < kMinPairs) return {};
  Eigen::Matrix3d damped = equations.hessian;
  // A trace of damping keeps an unobserved direction where it is.
  damped.diagonal() += 1e-6 * equations.hessian.diagonal() + Eigen::Vector3d::Constant(1e-6);
  const Eigen::Vector3d step = -solve_symmetric(damped, equations.gradient);
  if (!step.allFinite()) return {};
  return step;
}

/// Pulls a candidate in and judges it from both sides.
Look look_into(const ScanView& source, const ScanView& target, const Pose2& candidate) {
  Look look{.target_T_source = candidate};
  const std::size_t stride = stride_of(source);
  for (const double width : kPullWidthsM) {
    const auto step = solve(scan_equations(source, target, look.target_T_source, {stride, width}));
    if (!step) return look;
    look.target_T_source = RigidMotion<2>::moved(look.target_T_source, *step);
  }
  const Agreement there =
      scan_equations(source, target, look.target_T_source, {stride, kLookWidthM}).agreement;
  const Agreement back = scan_equations(target, source, look.target_T_source.inverse(),
                                        {stride_of(target), kLookWidthM})
                             .agreement;
  const auto rank = [](const Agreement& a) {
    return (a.explained - a.contradicted) / std::max(a.total(), 1e-9);
  };
  const auto sure = [](const Agreement& a) {
    return a.explained > kSureExplained * a.visible() && a.visible() > kSureVisible * a.total();
  };
  look.rank = rank(there) + rank(back);
  look.sure = sure(there) && sure(back);
  return look;
}

/// The guess pulled in, if that leaves no doubt; else the best candidate of the coarse search.
Look find_start(const ScanView& source, const ScanView& target, const Pose2& guess,
                const ScanMatchOptions& options) {
  Look best{.target_T_source = guess};
  if (options.search_half_xy_m <= 0.0 && options.search_half_yaw_rad <= 0.0) return best;
  best = look_into(source, target, guess);
  if (best.sure) return best;
  for (const Candidate& candidate :
       search_window(source, target, guess, options.search_half_xy_m, options.search_half_yaw_rad,
                     options.candidates)) {
    const Look look = look_into(source, target, candidate.target_T_source);
    if (look.rank > best.rank) best = look;
    if (look.sure) break;
  }
  return best;
}

struct Fit {
  Pose2 target_T_source;
  ScanEquations equations{};
  int iterations = 0;
  bool converged = false;
};

/// Gauss-Newton to the end. Along directions that `known` leaves open the pose stays.
Fit fit_finely(const ScanView& source, const ScanView& target, const Pose2& start,
               const ScanMatchOptions& options, const Observability<2>* known = nullptr) {
  Fit fit{.target_T_source = start};
  while (fit.iterations < options.max_iterations) {
    fit.equations =
        scan_equations(source, target, fit.target_T_source, {1, options.kernel_width_m});
    auto step = solve(fit.equations);
    if (!step) return fit;
    if (known != nullptr) step = known->observed_part(*step);
    ++fit.iterations;
    fit.target_T_source = RigidMotion<2>::moved(fit.target_T_source, *step);
    const double slack = fit.iterations < kPatientSteps ? 1.0 : kFlipSlack;
    fit.converged =
        step->head<2>().norm() < slack * kStepM && std::abs(step->z()) < slack * kStepRad;
    if (fit.converged) return fit;
  }
  return fit;
}

Observability<2> observability_of(const ScanKnowledge& knowledge) {
  return loopstone::observability_of<2>(knowledge.hessian, knowledge.centre, knowledge.arm_m);
}

bool convinces(const Agreement& agreement) {
  return agreement.explained >= kLeastOfVisible * agreement.visible() &&
         agreement.explained >= kLeastOfWhole * agreement.total();
}

MatchStatus status_of(const Fit& fit, const Agreement& back,
                      const Observability<2>& observability) {
  if (!fit.converged || !convinces(fit.equations.agreement) || !convinces(back))
    return MatchStatus::kNotConverged;
  return observability.complete() ? MatchStatus::kConverged : MatchStatus::kDegenerate;
}

}  // namespace

MatchResult match_scans(const ScanView& source, const ScanView& target,
                        const Pose2& guess_target_T_source, const ScanMatchOptions& options) {
  const Look start = find_start(source, target, guess_target_T_source, options);
  Fit fit = fit_finely(source, target, start.target_T_source, options);
  if (fit.equations.pairs < kMinPairs) {
    return {.target_T_source = guess_target_T_source, .status = MatchStatus::kTooFewPairs};
  }

  const FitScale fine{1, options.kernel_width_m};
  ScanKnowledge knowledge = scan_knowledge(source, target, fit.target_T_source, fine);
  Observability<2> observability = observability_of(knowledge);
  if (!observability.complete()) {
    // What the scans can't tell is not for the search to decide: there the guess stands.
    const Pose2& guess = guess_target_T_source;
    const Pose2 remapped = RigidMotion<2>::moved(
        guess, observability.observed_part(RigidMotion<2>::difference(fit.target_T_source, guess)));
    Fit again = fit_finely(source, target, remapped, options, &observability);
    if (again.equations.pairs >= kMinPairs) {
      again.iterations += fit.iterations;
      fit = again;
      knowledge = scan_knowledge(source, target, fit.target_T_source, fine);
      observability = observability_of(knowledge);
    }
  }

  const Agreement& agreement = fit.equations.agreement;
  const Agreement back =
      scan_equations(target, source, fit.target_T_source.inverse(), fine).agreement;
  return {.target_T_source = fit.target_T_source,
          .covariance = observability.covariance(knowledge.noise),
          .rmse_m = std::sqrt(fit.equations.squared_sum / fit.equations.weight_sum),
          .inlier_fraction = static_cast<double>(fit.equations.pairs) /
                             static_cast<double>(source.surfaces.size()),
          .pairs = fit.equations.pairs,
          .iterations = fit.iterations,
          .status = status_of(fit, back, observability),
          .score = agreement.explained / agreement.total()};
}

}  // namespace loopstone
