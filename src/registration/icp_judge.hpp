#pragma once

#include <span>

#include "loopstone/registration/icp.hpp"
#include "registration/icp_pairs.hpp"
#include "registration/observability.hpp"

namespace loopstone {

/// What the surfaces around the target points say about the motion, whatever the metric: a point on
/// a surface holds the motion across it. Where most points lie on no surface, those hold all
/// directions.
template <int kDimension>
[[nodiscard]] Observability<kDimension> surface_observability(
    std::span<const IcpPair<kDimension>> pairs, const IcpCloud<kDimension>& target);

/// Fills in how well the pairs at the final pose agree: everything of the result but the pose and
/// the iterations.
///
/// \param pairs        weighed
/// \param overlapping  source points that have a target point within options.max_pair_distance_m
/// \param source_size  finite source points
template <int kDimension>
void judge(BasicMatchResult<kDimension>& result, std::span<const IcpPair<kDimension>> pairs,
           const IcpCloud<kDimension>& target, IcpMetric metric, std::size_t overlapping,
           std::size_t source_size, const IcpOptions& options);

}  // namespace loopstone
