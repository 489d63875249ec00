// Places that may be one because they look alike, where poses say little.

#include <algorithm>
#include <limits>
#include <utility>

#include "loopstone/geometry/angle.hpp"
#include "slam/loop_candidates.hpp"
#include "slam/place_descriptor.hpp"

namespace loopstone {

namespace {

const std::vector<float>& descriptor_of(SubmapRecord& submap) {
  if (submap.descriptor.empty() && submap.frozen)
    submap.descriptor = describe_place(submap.frozen->surfaces);
  return submap.descriptor;
}

/// Centre on centre, any heading.
LoopCandidate centred(LoopCandidate candidate, const SubmapRecord& older,
                      const SubmapRecord& newer) {
  const double yaw = candidate.older_T_newer.yaw;
  const Eigen::Vector2d shift = older.centre - Pose2{0.0, 0.0, yaw}.rotation() * newer.centre;
  candidate.older_T_newer = {shift.x(), shift.y(), yaw};
  candidate.half_xy_m = kLoopCandidates.place_half_m;
  candidate.half_yaw_rad = kPi;
  candidate.by_appearance = true;
  return candidate;
}

}  // namespace

std::vector<LoopCandidate> by_appearance(std::span<const SubmapRecord> submaps,
                                         std::span<const LoopCandidate> candidates) {
  std::vector<LoopCandidate> laid;
  for (const LoopCandidate& candidate : candidates) {
    laid.push_back(
        centred(candidate, submaps[candidate.older.index], submaps[candidate.newer.index]));
    laid.back().either_way = true;
  }
  return laid;
}

std::vector<LoopCandidate> most_alike(std::span<SubmapRecord> submaps, SubmapId newer,
                                      std::span<const LoopCandidate> far, int most) {
  if (most <= 0 || far.empty()) return {};
  const auto& descriptor = descriptor_of(submaps[newer.index]);
  if (descriptor.empty()) return {};
  std::vector<std::pair<double, LoopCandidate>> ranked;
  for (const LoopCandidate& candidate : far) {
    const auto& other = descriptor_of(submaps[candidate.older.index]);
    if (!other.empty()) ranked.emplace_back(place_distance(descriptor, other), candidate);
  }
  std::ranges::stable_sort(ranked, {}, [](const auto& entry) { return entry.first; });
  const auto count = static_cast<std::size_t>(most);
  double unlike = std::numeric_limits<double>::infinity();
  if (ranked.size() > count) {
    unlike = kLoopCandidates.unlike * ranked[ranked.size() / 2].first;
    ranked.erase(ranked.begin() + static_cast<std::ptrdiff_t>(count), ranked.end());
  }
  std::vector<LoopCandidate> alike;
  for (const auto& [distance, candidate] : ranked) {
    if (distance > unlike) continue;
    alike.push_back(
        centred(candidate, submaps[candidate.older.index], submaps[candidate.newer.index]));
  }
  return alike;
}

}  // namespace loopstone
