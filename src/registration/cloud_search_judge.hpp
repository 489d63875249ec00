#pragma once

#include <Eigen/Core>
#include <span>

#include "loopstone/registration/cloud_search.hpp"
#include "registration/cloud_search_refine.hpp"

namespace loopstone {

/// The answer when there are too few points: the identity, of unknown accuracy.
template <int kDimension>
[[nodiscard]] BasicMatchResult<kDimension> nothing_to_align();

/// How well the refined pose fits, and how far to trust it.
/// \param source           finite, in the order of the refined pairs
/// \param target_T_source  the refined pose, of the source as given
template <int kDimension>
[[nodiscard]] BasicMatchResult<kDimension> judge(
    std::span<const Eigen::Matrix<double, kDimension, 1>> source,
    const typename RigidMotion<kDimension>::Pose& target_T_source,
    const Refined<kDimension>& refined, const CloudModel<kDimension>& model,
    double least_explained);

/// The answer when another pose fits as well: either may be true, so that the covariance about the
/// one given has grown by half the square of the difference.
template <int kDimension>
[[nodiscard]] BasicMatchResult<kDimension> with_rival(
    BasicMatchResult<kDimension> match, const typename RigidMotion<kDimension>::Pose& rival);

}  // namespace loopstone
