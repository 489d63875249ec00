#include "localization/near_search.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "localization/map_tables.hpp"
#include "localization/place_search.hpp"
#include "loopstone/registration/map_match.hpp"

namespace loopstone {

namespace {

/// Wheels slip, and odometry lags, by so much.
constexpr double kSlipM = 0.6;
constexpr double kSlipRad = 0.6;
constexpr double kMostM = 4.0;
constexpr double kMostRad = 1.2;
constexpr double kSigmas = 3.0;
/// What is found explains the scan better than any other pose nearby does: by more where there are
/// more others, one of which may fit by chance.
constexpr double kBetterThanOthers = 0.07;
constexpr double kBetterPerM = 0.025;

SearchWindow window_around(const PoseWithCovariance2& foretold) {
  const Eigen::Matrix3d& covariance = foretold.covariance;
  const double sigma_m = std::sqrt(std::max(covariance(0, 0), covariance(1, 1)));
  return {.centre = foretold.pose,
          .half_xy_m = std::min(kSlipM + kSigmas * sigma_m, kMostM),
          .half_yaw_rad = std::min(kSlipRad + kSigmas * std::sqrt(covariance(2, 2)), kMostRad)};
}

}  // namespace

std::optional<PoseWithCovariance2> find_nearby(const LocalizationScan& scan,
                                               const LocalizationMap& map,
                                               const PoseWithCovariance2& foretold, double least) {
  MapMatchOptions options;
  options.distinct_m = 0.4;
  options.distinct_rad = 0.2;
  const SearchWindow window = window_around(foretold);
  const std::vector<MatchResult> poses = match_near(scan, map, window, options);
  std::vector<double> qualities;
  for (const MatchResult& match : poses)
    qualities.push_back(quality_of(fit_beams(scan, map, match.target_T_source)));
  const auto best = std::max_element(qualities.begin(), qualities.end());
  if (best == qualities.end() || *best < least) return {};
  const double better = kBetterThanOthers + kBetterPerM * (window.half_xy_m - kSlipM);
  const bool only = std::all_of(qualities.begin(), qualities.end(), [&](const double& quality) {
    return &quality == &*best || quality <= *best - better;
  });
  if (!only) return {};
  const MatchResult& match = poses[static_cast<std::size_t>(best - qualities.begin())];
  return PoseWithCovariance2{match.target_T_source, match.covariance};
}

}  // namespace loopstone
