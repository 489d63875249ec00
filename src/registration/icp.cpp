#include "loopstone/registration/icp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "registration/icp_judge.hpp"
#include "registration/icp_pairs.hpp"
#include "registration/icp_step.hpp"

namespace loopstone {

namespace {

/// Pairs may change to and fro for ever. When the residuals have not shrunk by the tolerance for so
/// many steps, that is it.
constexpr int kPatientSteps = 5;
/// After unobserved directions went back to the guess, the observed ones settle in so many steps.
constexpr int kSettlingSteps = 5;

/// The pair distance shrinks at once to so many times the last step's length: what is left is no
/// longer than that.
constexpr double kStepsAhead = 10.0;

/// The pair distance and the kernel's width of the next step.
class Schedule {
 public:
  explicit Schedule(const IcpOptions& options)
      : distance_m_(options.max_pair_distance_m), final_m_(options.max_pair_distance_m) {
    if (options.final_pair_distance_m > 0.0) {
      final_m_ = std::min(options.final_pair_distance_m, final_m_);
    }
    factor_ = std::pow(final_m_ / distance_m_, 1.0 / options.shrink_iterations);
  }
  [[nodiscard]] double pair_distance_m() const { return distance_m_; }
  /// How many times the final pair distance it is.
  [[nodiscard]] double excess() const { return distance_m_ / final_m_; }
  [[nodiscard]] bool ended() const { return distance_m_ <= final_m_; }
  /// \param moved_m  by how much the last step moved the points
  void shrink(double moved_m) {
    distance_m_ = std::min(factor_ * distance_m_, kStepsAhead * moved_m);
    if (distance_m_ < final_m_ * (1.0 + 1e-9)) distance_m_ = final_m_;
  }

 private:
  double distance_m_;
  double final_m_;
  double factor_;
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
        metric_(metric_for(options.metric, kDimension)),
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
      const bool at_final_distance = schedule_.ended();
      schedule_.shrink(moved_m(before, result.target_T_source));
      find_pairs(result);
      if (!at_final_distance) continue;
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
    found_ = finder_.find(result.target_T_source, schedule_.pair_distance_m());
    cost_ = weigh<kDimension>(found_, options_.trim_fraction, options_.kernel,
                              options_.kernel_width_m * schedule_.excess());
    pairs_ = found_;
  }

  void move(Result& result) {
    result.target_T_source =
        step<kDimension>(pairs_, metric_, result.target_T_source, schedule_.pair_distance_m());
  }

  /// Root mean square over the pairs.
  [[nodiscard]] double moved_m(const Pose& before, const Pose& after) const {
    const auto change = (Motion::rotation(after) - Motion::rotation(before)).eval();
    const auto shift = (Motion::translation(after) - Motion::translation(before)).eval();
    double sum = 0.0;
    for (const auto& pair : pairs_) sum += (change * pair.source + shift).squaredNorm();
    return std::sqrt(sum / static_cast<double>(pairs_.size()));
  }

  [[nodiscard]] bool too_few() const { return pairs_.size() < Motion::kDof; }

  [[nodiscard]] bool is_small(const typename Motion::Tangent& motion) const {
    constexpr int kTurns = Motion::kDof - kDimension;
    return motion.template head<kDimension>().norm() < options_.tolerance_m &&
           motion.template tail<kTurns>().norm() < options_.tolerance_rad;
  }

  /// Takes back what the pairs cannot tell: along unobserved directions the guess stands.
  void keep_guess_where_unobserved(Result& result, const Pose& guess) {
    const auto observability = surface_observability<kDimension>(pairs_, target_);
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
    return finder_.count_within(result.target_T_source, options_.max_pair_distance_m);
  }

  Result without_pose(Result result, const Pose& guess) const {
    result.target_T_source = guess;
    result.covariance = Result::unknown_covariance();
    result.pairs = static_cast<int>(pairs_.size());
    result.status = MatchStatus::kTooFewPairs;
    return result;
  }

  const IcpCloud<kDimension>& target_;
  const IcpOptions& options_;
  Schedule schedule_;
  IcpMetric metric_;
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
  if (metric_for(options.metric, kDimension) == IcpMetric::kGicp) {
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
