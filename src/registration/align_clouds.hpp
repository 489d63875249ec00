#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "loopstone/registration/align.hpp"

// Alignment of bare points, the same in the plane and in space.
namespace loopstone {

template <int kDimension>
using PointSpan = std::span<const Eigen::Matrix<double, kDimension, 1>>;

/// From one start, or with sweep_yaw from many around it; of several the best ending.
template <int kDimension>
void match_from_starts(AlignResult<kDimension>& result, const AlignRequest<kDimension>& request,
                       std::vector<typename RigidMotion<kDimension>::Pose> starts,
                       const Matcher<kDimension>& matcher);

/// ICP from the guess; without a guess, and with nothing else asked for, from the identity and from
/// the centroids, and by search where neither fits. `anywhere` searches at once.
template <int kDimension>
void align_clouds(AlignResult<kDimension>& result, PointSpan<kDimension> source,
                  PointSpan<kDimension> target, const AlignRequest<kDimension>& request,
                  const AlignOptions<kDimension>& options);

extern template void match_from_starts<2>(AlignResult<2>&, const AlignRequest<2>&,
                                          std::vector<Pose2>, const Matcher<2>&);
extern template void match_from_starts<3>(AlignResult<3>&, const AlignRequest<3>&,
                                          std::vector<Pose3>, const Matcher<3>&);
extern template void align_clouds<2>(AlignResult<2>&, PointSpan<2>, PointSpan<2>,
                                     const AlignRequest<2>&, const AlignOptions<2>&);
extern template void align_clouds<3>(AlignResult<3>&, PointSpan<3>, PointSpan<3>,
                                     const AlignRequest<3>&, const AlignOptions<3>&);

}  // namespace loopstone
