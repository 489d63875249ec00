#include "loopstone/registration/weakest_direction.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace loopstone {

template <int kDimension>
WeakestDirection<kDimension> weakest_direction(const BasicMatchResult<kDimension>& match,
                                               double radius_m) {
  constexpr int kTurns = RigidMotion<kDimension>::kDof - kDimension;
  using Shifts = Eigen::Matrix<double, kDimension, kDimension>;
  using Turns = Eigen::Matrix<double, kTurns, kTurns>;
  const Eigen::SelfAdjointEigenSolver<Shifts> shifts(
      Shifts(match.covariance.template topLeftCorner<kDimension, kDimension>()));
  const Eigen::SelfAdjointEigenSolver<Turns> turns(
      Turns(match.covariance.template bottomRightCorner<kTurns, kTurns>()));
  const auto sigma = [](double variance) { return std::sqrt(std::max(variance, 0.0)); };

  WeakestDirection<kDimension> weakest;
  const double shift_sigma = sigma(shifts.eigenvalues()(kDimension - 1));
  const double turn_sigma = sigma(turns.eigenvalues()(kTurns - 1));
  weakest.is_turn = turn_sigma * radius_m > shift_sigma;
  weakest.sigma = weakest.is_turn ? turn_sigma : shift_sigma;
  if (!weakest.is_turn) {
    weakest.direction = shifts.eigenvectors().col(kDimension - 1);
  } else if constexpr (kTurns == kDimension) {
    weakest.direction = turns.eigenvectors().col(kTurns - 1);
  }
  // An eigenvector's sign is arbitrary.
  for (const double component : weakest.direction) {
    if (std::abs(component) < 1e-9) continue;
    if (component < 0.0) weakest.direction = -weakest.direction;
    break;
  }
  return weakest;
}

template WeakestDirection<2> weakest_direction<2>(const MatchResult&, double);
template WeakestDirection<3> weakest_direction<3>(const MatchResult3&, double);

}  // namespace loopstone
