#include "registration/observability.hpp"

#include "geometry/symmetric_matrix.hpp"

namespace loopstone {

namespace {

/// A direction with less than this share of the best one's information counts as unobserved: noise
/// of normals alone pretends to a few thousandths.
constexpr double kObservedShare = 0.01;

}  // namespace

template <int kDimension>
Observability<kDimension> observability_of(
    const typename Observability<kDimension>::Matrix& information,
    const typename RigidMotion<kDimension>::Vector& centre, double arm_m) {
  using Motion = RigidMotion<kDimension>;
  constexpr int kTurns = Motion::kDof - kDimension;
  Observability<kDimension> result;
  // A point at `arm` moves by t + w x arm = (t + w x centre) + w x (arm - centre).
  const auto centre_jacobian = Motion::point_jacobian(centre);
  result.to_scaled.setIdentity();
  result.to_scaled.template topRows<kDimension>() = centre_jacobian;
  result.to_scaled.template bottomRightCorner<kTurns, kTurns>() *= arm_m;
  result.from_scaled.setIdentity();
  result.from_scaled.template topRightCorner<kDimension, kTurns>() =
      -centre_jacobian.template rightCols<kTurns>() / arm_m;
  result.from_scaled.template bottomRightCorner<kTurns, kTurns>() /= arm_m;
  using Matrix = typename Observability<kDimension>::Matrix;
  const Matrix scaled = result.from_scaled.transpose() * information * result.from_scaled;
  const auto eigen = symmetric_eigen(scaled);
  result.directions = eigen.vectors;
  result.information = eigen.values.cwiseMax(0.0);
  result.observed =
      result.information.array() > kObservedShare * result.information(Motion::kDof - 1);
  return result;
}

template <int kDimension>
typename Observability<kDimension>::Tangent Observability<kDimension>::observed_part(
    const Tangent& motion) const {
  if (complete()) return motion;
  const Tangent along = directions.transpose() * (to_scaled * motion);
  const Tangent kept = observed.select(along, Tangent::Zero());
  return from_scaled * (directions * kept);
}

template <int kDimension>
typename Observability<kDimension>::Tangent Observability<kDimension>::solve(
    const Tangent& gradient) const {
  const Tangent along = directions.transpose() * (from_scaled.transpose() * gradient);
  Tangent step = Tangent::Zero();
  for (int i = 0; i < kDof; ++i) {
    if (observed(i)) step(i) = -along(i) / information(i);
  }
  return from_scaled * (directions * step);
}

template <int kDimension>
typename Observability<kDimension>::Matrix Observability<kDimension>::covariance(
    const Matrix& noise) const {
  const Matrix basis = from_scaled * directions;
  Matrix inverse = Matrix::Zero();
  Matrix open = Matrix::Zero();
  for (int i = 0; i < kDof; ++i) {
    const Matrix along = basis.col(i) * basis.col(i).transpose();
    if (observed(i)) {
      inverse += along / information(i);
    } else {
      open += kUnobservedSigmaM * kUnobservedSigmaM * along;
    }
  }
  const Matrix result = inverse * noise * inverse + open;
  return 0.5 * (result + result.transpose());
}

template struct Observability<2>;
template struct Observability<3>;
template Observability<2> observability_of<2>(const Observability<2>::Matrix&,
                                              const Eigen::Vector2d&, double);
template Observability<3> observability_of<3>(const Observability<3>::Matrix&,
                                              const Eigen::Vector3d&, double);

}  // namespace loopstone
