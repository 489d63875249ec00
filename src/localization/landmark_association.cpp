#include "loopstone/localization/landmark_association.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

/// Wider than this a first-order step from pair to pair leads astray, and all pairs so far are
/// taken into the prior anew.
constexpr double kNarrowM = 0.2;
constexpr double kNarrowRad = 0.03;

bool is_wide(const Eigen::Matrix3d& covariance) {
  return covariance.topLeftCorner<2, 2>().trace() > 2.0 * kNarrowM * kNarrowM ||
         covariance(2, 2) > kNarrowRad * kNarrowRad;
}

/// Pairs so far: where the robot is by them, and how probable they are.
struct Paired {
  PoseWithCovariance2 map_T_robot{};
  double chi2 = 0.0;
  double log_density = 0.0;
};

/// One pair more, to first order: what Kalman's filter does.
Paired with_pair(const Paired& before, const LandmarkObservation& observation,
                 const MappedLandmark& landmark) {
  const PoseWithCovariance2& prior = before.map_T_robot;
  const LinearSighting seen = linearised(prior.pose, observation, landmark);
  const Eigen::Matrix2d spread =
      seen.jacobian * prior.covariance * seen.jacobian.transpose() + seen.noise;
  const Eigen::Matrix2d inverse = spread.inverse();
  const Eigen::Matrix<double, 3, 2> gain = prior.covariance * seen.jacobian.transpose() * inverse;
  const double chi2 = seen.innovation.dot(inverse * seen.innovation);
  Paired paired;
  paired.chi2 = before.chi2 + chi2;
  paired.log_density = before.log_density -
                       0.5 * (chi2 + std::log(spread.determinant()) + 2.0 * std::log(2.0 * kPi));
  const Eigen::Vector3d move = gain * seen.innovation;
  paired.map_T_robot.pose = {prior.pose.x + move.x(), prior.pose.y + move.y(),
                             wrap_angle(prior.pose.yaw + move.z())};
  const Eigen::Matrix3d kept = Eigen::Matrix3d::Identity() - gain * seen.jacobian;
  // Joseph's form keeps it symmetric and positive.
  paired.map_T_robot.covariance =
      kept * prior.covariance * kept.transpose() + gain * seen.noise * gain.transpose();
  return paired;
}

/// Depth first, the better branch first; a branch is left when even the best densities of all that
/// remain could not beat the best set so far.
class AssociationSearch {
 public:
  AssociationSearch(const PoseWithCovariance2& prior, const LandmarkMap& map,
                    std::span<const LandmarkObservation> observations, const ClutterModel& clutter,
                    int most_nodes)
      : prior_(prior),
        is_wide_(is_wide(prior.covariance)),
        map_(map),
        observations_(observations),
        clutter_(clutter),
        nodes_left_(most_nodes),
        current_(observations.size()),
        taken_(map.size(), false),
        best_possible_(observations.size() + 1, 0.0) {
    for (std::size_t i = observations.size(); i-- > 0;) {
      // S is R at least.
      const double peak = -0.5 * std::log(observations[i].covariance.determinant()) -
                          std::log(2.0 * kPi) + clutter.log_landmark();
      best_possible_[i] = best_possible_[i + 1] + std::max(peak, clutter.log_clutter());
    }
    best_.log_probability = -std::numeric_limits<double>::infinity();
  }

  JointAssociation run() {
    visit(0, {.map_T_robot = prior_}, 0.0);
    best_.complete = nodes_left_ > 0;
    if (is_wide_) add_left_over();
    return std::move(best_);
  }

 private:
  struct Branch {
    std::size_t landmark = 0;
    Paired paired{};
  };

  /// \param log_shares  of the observations before: whether they are of a landmark, and clutter
  void visit(std::size_t at, const Paired& paired, double log_shares) {
    const double so_far = paired.log_density + log_shares;
    if (so_far + best_possible_[at] <= best_.log_probability) return;
    if (at == observations_.size()) {
      best_ = {current_, so_far, true};
      return;
    }
    // The first way down is always gone to its end, so that there is an answer.
    if (--nodes_left_ < 0 && !best_.landmarks.empty()) return;
    for (const Branch& branch : branches_of(at, paired)) {
      current_[at] = branch.landmark;
      taken_[branch.landmark] = true;
      visit(at + 1, branch.paired, log_shares + clutter_.log_landmark());
      taken_[branch.landmark] = false;
      current_[at].reset();
    }
    visit(at + 1, paired, log_shares + clutter_.log_clutter());
  }

  /// What a wide prior kept out at first may fit well once the others tell where the robot is.
  void add_left_over() {
    const LandmarkPosterior posterior =
        update_by_landmarks(prior_, map_, observations_, best_.landmarks);
    if (posterior.observations == 0) return;
    Paired paired{posterior.map_T_robot};
    for (const auto& landmark : best_.landmarks) {
      if (landmark) taken_[*landmark] = true;
    }
    is_wide_ = false;
    for (std::size_t at = 0; at < observations_.size(); ++at) {
      if (best_.landmarks[at]) continue;
      const std::vector<Branch> branches = branches_of(at, paired);
      if (branches.empty()) continue;
      const double gain = branches.front().paired.log_density - paired.log_density +
                          clutter_.log_landmark() - clutter_.log_clutter();
      if (gain <= 0.0) continue;
      best_.landmarks[at] = branches.front().landmark;
      best_.log_probability += gain;
      taken_[branches.front().landmark] = true;
      paired = branches.front().paired;
    }
  }

  /// Landmarks that an observation may be of, the most probable first.
  [[nodiscard]] std::vector<Branch> branches_of(std::size_t at, const Paired& paired) {
    std::vector<Branch> branches;
    for (const std::size_t landmark : candidates_of(at, paired.map_T_robot)) {
      if (taken_[landmark]) continue;
      Branch branch{landmark, is_wide_ ? from_prior(at, landmark)
                                       : with_pair(paired, observations_[at], map_[landmark])};
      if (branch.paired.chi2 - paired.chi2 <= clutter_.gate_chi2) branches.push_back(branch);
    }
    std::ranges::stable_sort(branches, std::greater{},
                             [](const Branch& branch) { return branch.paired.log_density; });
    return branches;
  }

  /// All pairs so far and this one, taken into the prior together.
  [[nodiscard]] Paired from_prior(std::size_t at, std::size_t landmark) {
    current_[at] = landmark;
    const LandmarkPosterior posterior = update_by_landmarks(prior_, map_, observations_, current_);
    current_[at].reset();
    return {posterior.map_T_robot, posterior.chi2, posterior.log_evidence};
  }

  [[nodiscard]] std::vector<std::size_t> candidates_of(std::size_t at,
                                                       const PoseWithCovariance2& pose) const {
    const LandmarkObservation& observation = observations_[at];
    if (observation.id) {
      const auto named = map_.index_of(*observation.id);
      return named ? std::vector{*named} : std::vector<std::size_t>{};
    }
    return map_.within(pose.pose * observation.point, reach_of(observation, pose));
  }

  /// No landmark farther than this passes the gate.
  [[nodiscard]] double reach_of(const LandmarkObservation& observation,
                                const PoseWithCovariance2& pose) const {
    const double sigma = map_.largest_sigma_m();
    const double way = observation.point.norm() + map_.largest_radius_m();
    const double variance = pose.covariance.topLeftCorner<2, 2>().trace() +
                            2.0 * way * way * pose.covariance(2, 2) +
                            observation.covariance.trace() + 2.0 * sigma * sigma;
    // Twice: a variance along any axis is no larger than twice the sum of both parts'.
    return map_.largest_radius_m() + std::sqrt(2.0 * clutter_.gate_chi2 * variance);
  }

  const PoseWithCovariance2& prior_;
  bool is_wide_;
  const LandmarkMap& map_;
  std::span<const LandmarkObservation> observations_;
  ClutterModel clutter_;
  int nodes_left_;
  LandmarkAssociation current_;
  std::vector<bool> taken_;
  std::vector<double> best_possible_;  ///< of the observations from here on
  JointAssociation best_{};
};

}  // namespace

double ClutterModel::log_landmark() const { return std::log1p(-share); }

double ClutterModel::log_clutter() const { return std::log(share) + log_anywhere(); }

double ClutterModel::log_anywhere() const { return -std::log(kPi * max_range_m * max_range_m); }

JointAssociation associate_jointly(const PoseWithCovariance2& prior, const LandmarkMap& map,
                                   std::span<const LandmarkObservation> observations,
                                   const ClutterModel& clutter, int most_nodes) {
  return AssociationSearch(prior, map, observations, clutter, most_nodes).run();
}

}  // namespace loopstone
