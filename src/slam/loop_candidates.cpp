#include "slam/loop_candidates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <queue>
#include <utility>

#include "loopstone/geometry/angle.hpp"
#include "slam/drives.hpp"

namespace loopstone {

namespace {

/// Travel beyond which nothing changes.
double enough_travel_m(const LoopOptions& options) {
  if (options.places_max > 0) return std::numeric_limits<double>::infinity();
  return std::max(options.max_half_xy_m / std::max(options.drift_per_m, 1e-9),
                  kLoopCandidates.half_yaw_most_rad / std::max(options.drift_rad_per_m, 1e-9));
}

/// How far a place lies from the break by which a piece of the path began, and what is known of the
/// motion across.
struct NearBreak {
  double travel_m = 0.0;  ///< from either place to the break, together
  double sigma_m = 0.0;
  double sigma_rad = 0.0;
  bool is_of_drives = false;  ///< another drive begins there
};

/// Of a pair in two pieces that follow one another.
std::optional<NearBreak> break_between(std::span<const SubmapRecord> submaps, std::size_t older,
                                       std::size_t newer) {
  if (submaps[older].piece + 1 != submaps[newer].piece) return {};
  std::size_t first = newer;
  while (first > 0 && submaps[first - 1].piece == submaps[newer].piece) --first;
  if (first == 0 || submaps[first].keys.empty()) return {};
  const auto& across = submaps[first].keys.front().across;
  if (!across) return {};
  return NearBreak{submaps[newer].travelled_m - submaps[first].travelled_m +
                       submaps[first - 1].travelled_m - submaps[older].travelled_m,
                   std::sqrt(std::max((*across)(0, 0), (*across)(1, 1))),
                   std::sqrt((*across)(2, 2)), submaps[first].keys.front().starts_drive};
}

/// Across a break after which the robot may face anywhere, but can't be far: all of it is searched.
/// \return whether both places lie right at the break, and have something in common in any case
bool widen_across_break(const NearBreak& gap, const LoopOptions& options,
                        LoopCandidate& candidate) {
  const double half_xy_m = kLoopCandidates.rest_m + options.drift_per_m * gap.travel_m +
                           kLoopCandidates.break_sigmas * gap.sigma_m;
  const double half_yaw_rad = kLoopCandidates.rest_rad + options.drift_rad_per_m * gap.travel_m +
                              kLoopCandidates.break_sigmas * gap.sigma_rad;
  if (gap.travel_m > kLoopCandidates.near_break_m || half_xy_m > options.max_half_xy_m ||
      half_yaw_rad < candidate.half_yaw_rad)
    return false;
  candidate.half_xy_m = half_xy_m;
  candidate.half_yaw_rad = std::min(half_yaw_rad, kPi);
  return gap.travel_m <= kLoopCandidates.at_break_m;
}

}  // namespace

std::vector<double> travel_from(std::span<const SubmapRecord> submaps, SubmapId from,
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
    for (const SubmapId other : submaps[at].closed_with)
      reach(other.index, cost + kLoopCandidates.closure_travel_m);
  }
  return travel;
}

LoopCandidates candidates_for(std::span<const SubmapRecord> submaps, SubmapId newer,
                              const LoopOptions& options,
                              const std::function<bool(SubmapId older)>& skips) {
  LoopCandidates candidates;
  const SubmapRecord& query = submaps[newer.index];
  if (query.state == SubmapState::kDropped) return candidates;
  const Pose2 map_T_newer = query.map_T_submap;
  const Eigen::Vector2d centre = map_T_newer * query.centre;
  const auto travel = travel_from(submaps, newer, enough_travel_m(options));
  const Drives drives(submaps);
  for (std::size_t older = 0; older < newer.index; ++older) {
    const SubmapRecord& target = submaps[older];
    if (target.state == SubmapState::kDropped || skips({older})) continue;
    if (older + kLoopCandidates.neighbours >= newer.index && target.piece == query.piece) continue;
    const Pose2 map_T_older = target.map_T_submap;
    const double uncertain_m = kLoopCandidates.rest_m + options.drift_per_m * travel[older];
    const double uncertain_rad = kLoopCandidates.rest_rad + options.drift_rad_per_m * travel[older];
    LoopCandidate candidate{
        .older = {older},
        .newer = newer,
        .older_T_newer = map_T_older.inverse() * map_T_newer,
        .half_xy_m = std::min(uncertain_m, options.max_half_xy_m),
        .half_yaw_rad = std::min(uncertain_rad, kLoopCandidates.half_yaw_most_rad),
        .distance_m = (centre - map_T_older * target.centre).norm()};
    if (drives.are_adrift({older}, newer)) {
      candidates.adrift.push_back(candidate);
      continue;
    }
    const auto gap = break_between(submaps, older, newer.index);
    candidate.across_break = gap && !gap->is_of_drives;
    const bool at_break = gap && widen_across_break(*gap, options, candidate);
    if (uncertain_m > options.max_half_xy_m &&
        candidate.distance_m <= uncertain_m + kLoopCandidates.place_half_m)
      candidates.far.push_back(candidate);
    if (at_break ||
        candidate.distance_m <=
            kLoopCandidates.near_radii * (query.radius_m + target.radius_m) + candidate.half_xy_m)
      candidates.near.push_back(candidate);
  }
  std::ranges::stable_sort(candidates.near, {}, &LoopCandidate::distance_m);
  return candidates;
}

}  // namespace loopstone
