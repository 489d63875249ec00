#include "registration/align_clouds.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

#include "loopstone/registration/icp_guess.hpp"

namespace loopstone {

namespace {

/// Poses closer to each other than this share of the source's radius are called one.
constexpr double kSameShare = 0.02;
/// CloudModel takes no fewer.
constexpr std::ptrdiff_t kLeastPoints = 3;

/// The metric of ICP that a method names.
IcpMetric icp_metric(AlignMethod method) {
  switch (method) {
    case AlignMethod::kIcpPoint:
      return IcpMetric::kPoint;
    case AlignMethod::kIcpLine:
      return IcpMetric::kLine;
    case AlignMethod::kGicp:
      return IcpMetric::kGicp;
    default:
      return IcpMetric::kPlane;
  }
}

/// No guess at all.
template <int kDimension>
AlignResult<kDimension> search_clouds(AlignResult<kDimension> result, PointSpan<kDimension> source,
                                      PointSpan<kDimension> target,
                                      const AlignRequest<kDimension>& request,
                                      const CloudSearchOptions& options) {
  result.method = "search";
  result.guess = initial_guess<kDimension>(IcpGuess::kCentroids, source, target);
  const auto usable =
      std::ranges::count_if(target, [](const auto& point) { return point.allFinite(); });
  if (usable < kLeastPoints) {
    result.match.target_T_source = result.guess;
    result.match.status = MatchStatus::kTooFewPairs;
    return result;
  }
  const CloudModel<kDimension> model{target};
  result.search = search_alignment<kDimension>(source, model, options, request.threads);
  result.match = result.search->match;
  return result;
}

}  // namespace

template <int kDimension>
void match_from_starts(AlignResult<kDimension>& result, const AlignRequest<kDimension>& request,
                       std::vector<typename RigidMotion<kDimension>::Pose> starts,
                       const Matcher<kDimension>& matcher) {
  if (request.sweep_yaw > 0)
    starts = headings_from<kDimension>(starts.front(), result.source, request.sweep_yaw);
  SweepResult<kDimension> sweep =
      match_from<kDimension>(starts, matcher, result.source, kSameShare * result.source.radius_m);
  result.match = sweep.best();
  result.guess = starts[sweep.endings.front().start];
  if (request.sweep_yaw > 0) result.sweep = std::move(sweep);
}

template <int kDimension>
void align_clouds(AlignResult<kDimension>& result, PointSpan<kDimension> source,
                  PointSpan<kDimension> target, const AlignRequest<kDimension>& request,
                  const AlignOptions<kDimension>& options) {
  using Pose = typename RigidMotion<kDimension>::Pose;
  const AlignResult<kDimension> blank{.source = result.source};
  if (request.anywhere) {
    result = search_clouds<kDimension>(blank, source, target, request, options.cloud_search);
    return;
  }
  IcpOptions icp = options.icp;
  icp.metric = icp_metric(request.method);
  const auto cloud_of = [&](PointSpan<kDimension> points) {
    return make_icp_cloud<kDimension>({points.begin(), points.end()}, options.icp_cloud);
  };
  const IcpCloud<kDimension> target_cloud = cloud_of(target);
  // Only this metric looks at the source's surfaces.
  std::optional<IcpCloud<kDimension>> source_cloud;
  if (icp.metric == IcpMetric::kGicp) source_cloud = cloud_of(source);
  const Matcher<kDimension> matcher = [&](const Pose& guess) {
    if (source_cloud) return match_icp<kDimension>(*source_cloud, target_cloud, guess, icp);
    return match_icp(source, target_cloud, guess, icp);
  };

  const Pose centroids = initial_guess<kDimension>(IcpGuess::kCentroids, source, target);
  const bool nothing_known = !request.is_guessed() && request.sweep_yaw == 0;
  const bool at_centroids =
      request.from_centroids || (!request.is_guessed() && request.sweep_yaw > 0);
  const bool free = request.method == AlignMethod::kAuto && nothing_known;
  std::vector<Pose> starts{at_centroids ? centroids : request.guess.value_or(Pose{})};
  if (free) starts.push_back(centroids);
  match_from_starts<kDimension>(result, request, std::move(starts), matcher);
  result.method =
      to_string(request.method == AlignMethod::kAuto ? AlignMethod::kIcpPlane : request.method);
  if (!free || has_supported_pose(result.match.status)) return;
  AlignResult<kDimension> searched =
      search_clouds<kDimension>(blank, source, target, request, options.cloud_search);
  if (has_supported_pose(searched.match.status)) result = std::move(searched);
}

template void match_from_starts<2>(AlignResult<2>&, const AlignRequest<2>&, std::vector<Pose2>,
                                   const Matcher<2>&);
template void match_from_starts<3>(AlignResult<3>&, const AlignRequest<3>&, std::vector<Pose3>,
                                   const Matcher<3>&);
template void align_clouds<2>(AlignResult<2>&, PointSpan<2>, PointSpan<2>, const AlignRequest<2>&,
                              const AlignOptions<2>&);
template void align_clouds<3>(AlignResult<3>&, PointSpan<3>, PointSpan<3>, const AlignRequest<3>&,
                              const AlignOptions<3>&);

}  // namespace loopstone
