#pragma once

#include <Eigen/Core>

#include "loopstone/registration/match_result.hpp"

namespace loopstone {

/// The motion that a match knows least about.
template <int kDimension>
struct WeakestDirection {
  bool is_turn = false;  ///< a turn about the source's origin, else a shift
  /// Target's axes, unit, the first component that is not 0 positive; of a turn in space its axis,
  /// in the plane zero.
  Eigen::Matrix<double, kDimension, 1> direction = Eigen::Matrix<double, kDimension, 1>::Zero();
  double sigma = 0.0;  ///< standard deviation [m, or rad]
};

/// \param radius_m  of the source: what a turn is compared with a shift by
template <int kDimension>
[[nodiscard]] WeakestDirection<kDimension> weakest_direction(
    const BasicMatchResult<kDimension>& match, double radius_m);

extern template WeakestDirection<2> weakest_direction<2>(const MatchResult&, double);
extern template WeakestDirection<3> weakest_direction<3>(const MatchResult3&, double);

}  // namespace loopstone
