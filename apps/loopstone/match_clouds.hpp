#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "loopstone/base/error.hpp"
#include "match_request.hpp"

// Matching of bare points, the same in the plane and in space.
namespace loopstone::app {

/// Lengths for clouds of this size, under what the user set.
template <int kDimension>
[[nodiscard]] MatchSettings<kDimension> settings_for_radius(double radius_m) {
  MatchSettings<kDimension> settings;
  settings.icp = icp_options_for_radius(radius_m);
  settings.icp_cloud = icp_cloud_options_for_radius<kDimension>(radius_m);
  return settings;
}

/// The metric of ICP that a method names.
[[nodiscard]] inline std::string icp_metric(const std::string& method) {
  if (method == "icp_point") return "point";
  if (method == "icp_line") return "line";
  return method == "gicp" ? "gicp" : "plane";
}

/// Poses closer to each other than this share of the source's radius are called one.
inline constexpr double kSameShare = 0.02;

/// From one start, or from --sweep-yaw many around it, or (auto without any guess) from several.
template <int kDimension>
void match_from_starts(MatchOutcome<kDimension>& outcome, const MatchRequest<kDimension>& request,
                       std::vector<typename RigidMotion<kDimension>::Pose> starts,
                       const Matcher<kDimension>& matcher) {
  if (request.sweep_yaw > 0)
    starts = headings_from<kDimension>(starts.front(), outcome.source, request.sweep_yaw);
  SweepResult<kDimension> sweep =
      match_from<kDimension>(starts, matcher, outcome.source, kSameShare * outcome.source.radius_m);
  outcome.match = sweep.best();
  outcome.guess = starts[sweep.endings.front().start];
  if (request.sweep_yaw > 0) outcome.sweep = std::move(sweep);
}

/// No guess at all.
template <int kDimension>
void search_clouds(MatchOutcome<kDimension>& outcome,
                   const std::vector<Eigen::Matrix<double, kDimension, 1>>& source,
                   const std::vector<Eigen::Matrix<double, kDimension, 1>>& target,
                   const MatchRequest<kDimension>& request,
                   const MatchSettings<kDimension>& settings) {
  using Point = Eigen::Matrix<double, kDimension, 1>;
  const auto usable =
      std::ranges::count_if(target, [](const Point& point) { return point.allFinite(); });
  if (usable < 3) {
    throw DataError({request.target_name},
                    "has fewer than 3 points with finite coordinates; nothing can be laid on it");
  }
  const CloudModel<kDimension> model{target};
  outcome.search = search_alignment<kDimension>(std::span<const Point>(source), model,
                                                settings.cloud_search, request.threads);
  outcome.match = outcome.search->match;
  outcome.method = "search";
  outcome.guess = initial_guess<kDimension>(IcpGuess::kCentroids, source, target);
}

/// ICP from the guess; `auto` without one begins at the identity and at the centroids, takes the better, and searches when
/// neither fits.
template <int kDimension>
void match_clouds(MatchOutcome<kDimension>& outcome,
                  const std::vector<Eigen::Matrix<double, kDimension, 1>>& source,
                  const std::vector<Eigen::Matrix<double, kDimension, 1>>& target,
                  const MatchRequest<kDimension>& request,
                  const MatchSettings<kDimension>& settings) {
  using Pose = typename RigidMotion<kDimension>::Pose;
  if (request.global) return search_clouds(outcome, source, target, request, settings);

  IcpOptions icp = settings.icp;
  icp.metric = icp_metric(request.method);
  const IcpCloud<kDimension> target_cloud = make_icp_cloud<kDimension>(target, settings.icp_cloud);
  // Only this metric looks at the source's surfaces.
  std::optional<IcpCloud<kDimension>> source_cloud;
  if (icp.metric == "gicp") source_cloud = make_icp_cloud<kDimension>(source, settings.icp_cloud);
  const Matcher<kDimension> matcher = [&](const Pose& guess) {
    if (source_cloud) return match_icp<kDimension>(*source_cloud, target_cloud, guess, icp);
    return match_icp(std::span(source), target_cloud, guess, icp);
  };
  const Pose centroids = initial_guess<kDimension>(IcpGuess::kCentroids, source, target);
  const bool guessed = request.from_centroids || request.initial;
  const bool free = request.method == "auto" && !guessed && request.sweep_yaw == 0;
  const bool at_centroids = request.from_centroids || (!guessed && request.sweep_yaw > 0);
  std::vector<Pose> starts{at_centroids ? centroids : request.initial.value_or(Pose{})};
  if (free) starts.push_back(centroids);
  match_from_starts<kDimension>(outcome, request, starts, matcher);
  outcome.method = request.method == "auto" ? "icp_plane" : request.method;
  if (!free || has_supported_pose(outcome.match.status)) return;
  MatchOutcome<kDimension> searched{.source = outcome.source};
  search_clouds(searched, source, target, request, settings);
  if (has_supported_pose(searched.match.status)) outcome = std::move(searched);
}

}  // namespace loopstone::app
