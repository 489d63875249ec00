#include "loopstone/registration/weakest_direction.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/symmetric_matrix.hpp"

namespace loopstone {

template <int kDimension>
WeakestDirection<kDimension> weakest_direction(const BasicMatchResult<kDimension>& match,
                                               double radius_m) {
  constexpr int kTurns = RigidMotion<kDimension>::kDof - kDimension;
  using Shifts = Eigen::Matrix<double, kDimension, kDimension>;
  using Turns = Eigen::Matrix<double, kTurns, kTurns>;
  const auto shifts =
      symmetric_eigen(Shifts(match.covariance.template topLeftCorner<kDimension, kDimension>()));
  const auto turns =
      symmetric_eigen(Turns(match.covariance.template bottomRightCorner<kTurns, kTurns>()));
  const auto sigma = [](double variance) { return std::sqrt(std::max(variance, 0.0)); };

  WeakestDirection<kDimension> weakest;
  const double shift_sigma = sigma(shifts.values(kDimension - 1));
  const double turn_sigma = sigma(turns.values(kTurns - 1));
  weakest.is_turn = turn_sigma * radius_m > shift_sigma;
  weakest.sigma = weakest.is_turn ? turn_sigma : shift_sigma;
  if (!weakest.is_turn) {
    weakest.direction = shifts.vectors.col(kDimension - 1);
  } else if constexpr (kTurns == kDimension) {
    weakest.direction = turns.vectors.col(kTurns - 1);
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
