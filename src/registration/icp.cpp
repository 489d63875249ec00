#include "loopstone/registration/icp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "registration/icp_judge.hpp"
#include "registration/icp_pairs.hpp"
#include "registration/icp_step.hpp"

namespace loopstone {

namespace {

/// Pairs may change to and fro for ever. When the residuals have not shrunk by the tolerance for so many steps, that is it.
constexpr int kPatientSteps = 5;
/// After unobserved directions went back to the guess, the observed ones settle in so many steps.
constexpr int kSettlingSteps = 5;

/// The pair distance and the kernel's width of each step.
struct Schedule {
  double first_m;
  double ratio;  ///< last / first
  int steps;

  explicit Schedule(const IcpOptions& options)
      : first_m(options.max_pair_distance_m), ratio(1.0), steps(options.shrink_iterations) {
    if (options.final_pair_distance_m > 0.0 && options.final_pair_distance_m < first_m) {
      ratio = options.final_pair_distance_m / first_m;
    }
  }
  [[nodiscard]] double pair_distance_m(int step) const {
    return first_m * std::pow(ratio, std::min(1.0, static_cast<double>(step) / steps));
  }
  /// How many times the final pair distance that of the step is.
  [[nodiscard]] double excess(int step) const { return pair_distance_m(step) / (first_m * ratio); }
  [[nodiscard]] bool ended(int step) const { return ratio == 1.0 || step >= steps; }
};

template <int kDimension>
class Icp {
 public:
  using Motion = RigidMotion<kDimension>;
  using Pose = typename Motion::Pose;
  using Result = BasicMatchResult<kDimension>;

  Icp(const IcpSource<kDimension>& source, const IcpCloud<kDimension>& target,
      const IcpOptions& options)
      : target_(target),
        options_(options),
        schedule_(options),
        metric_(icp_metric_from(options.metric, kDimension)),
        kernel_(robust_kernel_from(options.kernel)),
        finder_(source, target, metric_) {}

  [[nodiscard]] Result match(const Pose& guess) {
    Result result;
    result.target_T_source = guess;
    find_pairs(result);
    double best_cost = std::numeric_limits<double>::infinity();
    int best_iteration = 0;
    while (result.iterations < options_.max_iterations) {
      if (too_few()) return without_pose(result, guess);
      const Pose before = result.target_T_source;
      move(result);
      ++result.iterations;
      find_pairs(result);
      if (!schedule_.ended(result.iterations)) continue;
      if (is_small(Motion::difference(result.target_T_source, before))) {
        result.status = MatchStatus::kConverged;
        break;
      }
      // Squares of residuals shrink by twice the share.
      if (cost_ < (1.0 - 2.0 * options_.tolerance_cost) * best_cost) {
        best_cost = cost_;
        best_iteration = result.iterations;
      } else if (result.iterations - best_iteration >= kPatientSteps) {
        result.status = MatchStatus::kConverged;
        break;
      }
    }
    if (too_few()) return without_pose(result, guess);
    keep_guess_where_unobserved(result, guess);
    if (too_few()) return without_pose(result, guess);
    judge<kDimension>(result, pairs_, target_, metric_, overlapping(result),
                      finder_.finite_points(), options_);
    return result;
  }

 private:
  void find_pairs(const Result& result) {
    found_ = finder_.find(result.target_T_source, schedule_.pair_distance_m(result.iterations));
    cost_ = weigh<kDimension>(found_, options_.trim_fraction, kernel_,
                              options_.kernel_width_m * schedule_.excess(result.iterations));
    pairs_ = found_;
  }

  void move(Result& result) {
    result.target_T_source = step<kDimension>(pairs_, metric_, result.target_T_source,
                                              schedule_.pair_distance_m(result.iterations));
  }

  [[nodiscard]] bool too_few() const { return pairs_.size() < Motion::kDof; }

  [[nodiscard]] bool is_small(const typename Motion::Tangent& motion) const {
    constexpr int kTurns = Motion::kDof - kDimension;
    return motion.template head<kDimension>().norm() < options_.tolerance_m &&
           motion.template tail<kTurns>().norm() < options_.tolerance_rad;
  }

  /// Takes back what the pairs cannot tell: along unobserved directions the guess stands.
  void keep_guess_where_unobserved(Result& result, const Pose& guess) {
    const auto translation = Motion::translation(result.target_T_source);
    const auto observability = surface_observability<kDimension>(pairs_, target_, translation);
    if (observability.complete()) return;
    result.target_T_source = Motion::moved(
        guess, observability.observed_part(Motion::difference(result.target_T_source, guess)));
    find_pairs(result);
    if (metric_ == IcpMetric::kPoint) return;  // its steps would drift along again
    for (int i = 0; i < kSettlingSteps && !too_few(); ++i) {
      move(result);
      find_pairs(result);
    }
  }

  /// Source points that have a target point within the first pair distance.
  [[nodiscard]] std::size_t overlapping(const Result& result) {
    if (schedule_.ratio == 1.0 && metric_ != IcpMetric::kPlane && metric_ != IcpMetric::kLine) {
      return pairs_.size();
    }
    return finder_.count_within(result.target_T_source, schedule_.first_m);
  }

  Result without_pose(Result result, const Pose& guess) const {
    result.target_T_source = guess;
    result.covariance.setIdentity();
    result.covariance *= kUnobservedSigmaM * kUnobservedSigmaM;
    result.pairs = static_cast<int>(pairs_.size());
    result.status = MatchStatus::kTooFewPairs;
    return result;
  }

  const IcpCloud<kDimension>& target_;
  const IcpOptions& options_;
  Schedule schedule_;
  IcpMetric metric_;
  RobustKernel kernel_;
  IcpPairFinder<kDimension> finder_;
  std::span<IcpPair<kDimension>> found_{};
  std::span<const IcpPair<kDimension>> pairs_{};
  double cost_ = 0.0;
};

template <int kDimension>
BasicMatchResult<kDimension> match_points(
    std::span<const Eigen::Matrix<double, kDimension, 1>> source,
    const IcpCloud<kDimension>& target,
    const typename RigidMotion<kDimension>::Pose& guess_target_T_source,
    const IcpOptions& options) {
  std::vector<SurfacePatch<kDimension>> patches;
  if (icp_metric_from(options.metric, kDimension) == IcpMetric::kGicp) {
    patches = surface_patches<kDimension>(PointIndex<kDimension>({source.begin(), source.end()}));
  }
  return Icp<kDimension>({source, patches}, target, options).match(guess_target_T_source);
}

}  // namespace

template <int kDimension>
BasicMatchResult<kDimension> match_icp(
    const IcpCloud<kDimension>& source, const IcpCloud<kDimension>& target,
    const typename RigidMotion<kDimension>::Pose& guess_target_T_source,
    const IcpOptions& options) {
  return Icp<kDimension>({source.points(), source.patches}, target, options)
      .match(guess_target_T_source);
}

MatchResult match_icp(std::span<const Eigen::Vector2d> source, const IcpCloud<2>& target,
                      const Pose2& guess_target_T_source, const IcpOptions& options) {
  return match_points<2>(source, target, guess_target_T_source, options);
}

MatchResult3 match_icp(std::span<const Eigen::Vector3d> source, const IcpCloud<3>& target,
                       const Pose3& guess_target_T_source, const IcpOptions& options) {
  return match_points<3>(source, target, guess_target_T_source, options);
}

template MatchResult match_icp<2>(const IcpCloud<2>&, const IcpCloud<2>&, const Pose2&,
                                  const IcpOptions&);
template MatchResult3 match_icp<3>(const IcpCloud<3>&, const IcpCloud<3>&, const Pose3&,
                                   const IcpOptions&);

}  // namespace loopstone
