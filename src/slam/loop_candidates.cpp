#include "slam/loop_candidates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

namespace loopstone {

namespace {

/// Submaps this close in sequence on one piece of the path share scans or are tied tightly already.
constexpr std::size_t kNeighbours = 2;
/// Uncertainty where two places are connected directly.
constexpr double kRestM = 0.35;
constexpr double kRestRad = 0.06;
constexpr double kMaxHalfYawRad = 0.8;
/// Travelling through a closure costs this much travel.
constexpr double kClosureTravelM = 1.0;
/// Two submaps nearer than this share of both their radii show parts of one place.
constexpr double kNearRadii = 0.7;

/// Travel beyond which nothing changes.
double enough_travel_m(const LoopOptions& options) {
  if (options.places_max > 0) return std::numeric_limits<double>::infinity();
  return std::max(options.max_half_xy_m / std::max(options.drift_per_m, 1e-9),
                  kMaxHalfYawRad / std::max(options.drift_rad_per_m, 1e-9));
}

}  // namespace

LoopSubmap loop_submap(FinishedSubmap submap, double travelled_m) {
  LoopSubmap kept;
  kept.submap = std::move(submap.submap);
  kept.piece = submap.piece;
  kept.travelled_m = travelled_m;
  const auto& surfaces = kept.submap.surfaces;
  if (surfaces.empty()) return kept;
  for (const auto& surface : surfaces) kept.centre += surface.position.cast<double>();
  kept.centre /= static_cast<double>(surfaces.size());
  double sum = 0.0;
  for (const auto& surface : surfaces)
    sum += (surface.position.cast<double>() - kept.centre).squaredNorm();
  kept.radius_m = std::sqrt(sum / static_cast<double>(surfaces.size()));
  return kept;
}

std::vector<double> travel_from(std::span<const LoopSubmap> submaps, SubmapId from,
                                double enough_m) {
  std::vector<double> travel(submaps.size(), std::numeric_limits<double>::infinity());
  using Item = std::pair<double, std::size_t>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> open;
  const auto reach = [&](std::size_t at, double cost) {
    if (cost >= travel[at] || cost > enough_m) return;
    travel[at] = cost;
    open.push({cost, at});
  };
  reach(from.index, 0.0);
  while (!open.empty()) {
    const auto [cost, at] = open.top();
    open.pop();
    if (cost > travel[at]) continue;
    const double here_m = submaps[at].travelled_m;
    if (at > 0) reach(at - 1, cost + here_m - submaps[at - 1].travelled_m);
    if (at + 1 < submaps.size()) reach(at + 1, cost + submaps[at + 1].travelled_m - here_m);
    for (const SubmapId other : submaps[at].closed_with) reach(other.index, cost + kClosureTravelM);
  }
  return travel;
}

LoopCandidates candidates_for(std::span<const LoopSubmap> submaps, SubmapId newer,
                              std::span<const Pose2> map_T_submap, const LoopOptions& options,
                              const std::function<bool(SubmapId older)>& skips) {
  LoopCandidates candidates;
  const LoopSubmap& query = submaps[newer.index];
  if (query.dropped) return candidates;
  const Pose2 map_T_newer = map_T_submap[newer.index];
  const Eigen::Vector2d centre = map_T_newer * query.centre;
  const auto travel = travel_from(submaps, newer, enough_travel_m(options));
  for (std::size_t older = 0; older < newer.index; ++older) {
    const LoopSubmap& target = submaps[older];
    if (target.dropped || skips({older})) continue;
    if (older + kNeighbours >= newer.index && target.piece == query.piece) continue;
    const Pose2 map_T_older = map_T_submap[older];
    const double uncertain_m = kRestM + options.drift_per_m * travel[older];
    const double uncertain_rad = kRestRad + options.drift_rad_per_m * travel[older];
    const LoopCandidate candidate{.older = {older},
                                  .newer = newer,
                                  .older_T_newer = map_T_older.inverse() * map_T_newer,
                                  .half_xy_m = std::min(uncertain_m, options.max_half_xy_m),
                                  .half_yaw_rad = std::min(uncertain_rad, kMaxHalfYawRad),
                                  .distance_m = (centre - map_T_older * target.centre).norm()};
    if (uncertain_m > options.max_half_xy_m && candidate.distance_m <= uncertain_m + kPlaceHalfM)
      candidates.far.push_back(candidate);
    if (candidate.distance_m <=
        kNearRadii * (query.radius_m + target.radius_m) + candidate.half_xy_m)
      candidates.near.push_back(candidate);
  }
  std::ranges::stable_sort(candidates.near, {}, &LoopCandidate::distance_m);
  return candidates;
}

}  // namespace loopstone
