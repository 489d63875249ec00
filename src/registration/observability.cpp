#include "registration/observability.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace loopstone {

namespace {

/// A direction with less than this share of the best one's information counts as unobserved: noise of normals alone
/// pretends to a few thousandths.
constexpr double kObservedShare = 0.01;
/// Standard deviation along an unobserved direction.
constexpr double kUnobservedSigmaM = 10.0;

}  // namespace

Observability observability_of(const Eigen::Matrix3d& information, const Eigen::Vector2d& centre,
                               double arm_m) {
  Observability result;
  // A point at `arm` moves by t + yaw * S arm = (t + yaw * S centre) + yaw * S (arm - centre), S = [0 -1; 1 0].
  result.to_scaled << 1.0, 0.0, -centre.y(),  //
      0.0, 1.0, centre.x(),                   //
      0.0, 0.0, arm_m;
  const Eigen::Matrix3d from_scaled = result.to_scaled.inverse();
  const Eigen::Matrix3d scaled = from_scaled.transpose() * information * from_scaled;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scaled);
  result.directions = eigen.eigenvectors();
  result.information = eigen.eigenvalues().cwiseMax(0.0);
  result.observed = result.information.array() > kObservedShare * result.information(2);
  return result;
}

Eigen::Vector3d Observability::observed_part(const Eigen::Vector3d& motion) const {
  if (complete()) return motion;
  const Eigen::Vector3d along = directions.transpose() * (to_scaled * motion);
  const Eigen::Vector3d kept = observed.select(along, Eigen::Vector3d::Zero());
  return to_scaled.inverse() * (directions * kept);
}

Eigen::Vector3d Observability::solve(const Eigen::Vector3d& gradient) const {
  const Eigen::Matrix3d from_scaled = to_scaled.inverse();
  const Eigen::Vector3d along = directions.transpose() * (from_scaled.transpose() * gradient);
  Eigen::Vector3d step = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    if (observed(i)) step(i) = -along(i) / information(i);
  }
  return from_scaled * (directions * step);
}

Eigen::Matrix3d Observability::covariance(double sigma) const {
  Eigen::Vector3d variances;
  for (int i = 0; i < 3; ++i) {
    variances(i) =
        observed(i) ? sigma * sigma / information(i) : kUnobservedSigmaM * kUnobservedSigmaM;
  }
  const Eigen::Matrix3d from_scaled = to_scaled.inverse();
  const Eigen::Matrix3d basis = from_scaled * directions;
  return basis * variances.asDiagonal() * basis.transpose();
}

}  // namespace loopstone
