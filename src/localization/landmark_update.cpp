#include "loopstone/localization/landmark_update.hpp"

#include <Eigen/LU>
#include <cmath>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/rigid_motion.hpp"

namespace loopstone {
namespace {

constexpr int kMostSteps = 20;
constexpr double kSmallStep = 1e-10;  ///< [m, rad]
constexpr int kMostHalvings = 12;

/// The cost whose minimum is the peak of the posterior, and its normal equations.
struct NormalEquations {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d descent = Eigen::Vector3d::Zero();  ///< minus half the gradient
  double cost = 0.0;
};

double log_determinant(const Eigen::MatrixXd& matrix) {
  const Eigen::LLT<Eigen::MatrixXd> factor(matrix);
  return 2.0 * factor.matrixLLT().diagonal().array().log().sum();
}

NormalEquations equations_at(const Pose2& pose, const PoseWithCovariance2& prior,
                             const Eigen::Matrix3d& prior_information, const LandmarkMap& map,
                             std::span<const LandmarkObservation> observations,
                             const LandmarkAssociation& association) {
  const Eigen::Vector3d off = RigidMotion<2>::difference(pose, prior.pose);
  NormalEquations equations{prior_information, -prior_information * off,
                            off.dot(prior_information * off)};
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!association[i]) continue;
    const LinearSighting seen = linearised(pose, observations[i], map[*association[i]]);
    const Eigen::Matrix2d weight = seen.noise.inverse();
    equations.information += seen.jacobian.transpose() * weight * seen.jacobian;
    equations.descent += seen.jacobian.transpose() * weight * seen.innovation;
    equations.cost += seen.innovation.dot(weight * seen.innovation);
  }
  return equations;
}

}  // namespace

// z = R^T (m - t):  dz/dt = -R^T,  dz/dyaw = (z_y, -z_x).
LinearSighting linearised(const Pose2& map_T_robot, const LandmarkObservation& observation,
                          const MappedLandmark& landmark) {
  const Eigen::Matrix2d robot_R_map = map_T_robot.rotation().transpose();
  const Eigen::Vector2d expected = robot_R_map * (landmark.position - map_T_robot.translation());
  LinearSighting linear;
  linear.innovation = centre_of(observation, landmark.radius_m) - expected;
  linear.jacobian.leftCols<2>() = -robot_R_map;
  linear.jacobian.col(2) << expected.y(), -expected.x();
  linear.noise =
      observation.covariance + landmark.sigma_m * landmark.sigma_m * Eigen::Matrix2d::Identity();
  return linear;
}

LandmarkPosterior update_by_landmarks(const PoseWithCovariance2& prior, const LandmarkMap& map,
                                      std::span<const LandmarkObservation> observations,
                                      const LandmarkAssociation& association) {
  LandmarkPosterior posterior{.map_T_robot = prior};
  double log_noise = 0.0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!association[i]) continue;
    ++posterior.observations;
    log_noise +=
        log_determinant(linearised(prior.pose, observations[i], map[*association[i]]).noise);
  }
  if (posterior.observations == 0) return posterior;
  const Eigen::Matrix3d prior_information = prior.covariance.inverse();
  const auto at = [&](const Pose2& pose) {
    return equations_at(pose, prior, prior_information, map, observations, association);
  };
  Pose2 pose = prior.pose;
  NormalEquations equations = at(pose);
  for (int i = 0; i < kMostSteps; ++i) {
    Eigen::Vector3d step = solve_symmetric(equations.information, equations.descent);
    NormalEquations next = at(RigidMotion<2>::moved(pose, step));
    // A step over a bend of the cost is halved until it leads down.
    for (int k = 0; k < kMostHalvings && next.cost > equations.cost; ++k) {
      step *= 0.5;
      next = at(RigidMotion<2>::moved(pose, step));
    }
    if (next.cost > equations.cost) break;
    pose = RigidMotion<2>::moved(pose, step);
    equations = next;
    if (step.cwiseAbs().maxCoeff() < kSmallStep) break;
  }
  const Eigen::Matrix3d covariance = equations.information.inverse();
  posterior.map_T_robot = {pose, 0.5 * (covariance + covariance.transpose())};
  posterior.chi2 = equations.cost;
  // |S| = |R| |P| / |P_posterior|: the determinant lemma.
  const double log_spread =
      log_noise + log_determinant(prior.covariance) + log_determinant(equations.information);
  posterior.log_evidence =
      -0.5 * (equations.cost + log_spread + 2.0 * posterior.observations * std::log(2.0 * kPi));
  return posterior;
}

}  // namespace loopstone
