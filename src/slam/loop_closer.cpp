#include "loopstone/slam/loop_closer.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "loopstone/base/hypotenuse.hpp"
#include "slam/drives.hpp"
#include "slam/loop_candidates.hpp"
#include "slam/loop_coverage.hpp"
#include "slam/loop_verification.hpp"

namespace loopstone {

namespace {

SubmapPair pair_of(const LoopClosure& closure) { return {closure.to_submap, closure.from_submap}; }
SubmapPair pair_of(const LoopCandidate& candidate) { return {candidate.newer, candidate.older}; }

}  // namespace

LoopCloser::LoopCloser(const LoopOptions& options, const SubmapOptions& submap,
                       const GridMatchOptions& match, Threads threads)
    : options_(options), submap_options_(submap), match_options_(match), threads_(threads) {}

void LoopCloser::set_closures(std::span<SubmapRecord> submaps,
                              std::span<const LoopClosure> closures) {
  const auto before = std::exchange(state_.standing, {});
  for (SubmapRecord& submap : submaps) submap.closed_with.clear();
  for (const auto& closure : closures) {
    if (!closure.stands()) continue;
    state_.standing.insert(pair_of(closure));
    submaps[closure.from_submap.index].closed_with.push_back(closure.to_submap);
    submaps[closure.to_submap.index].closed_with.push_back(closure.from_submap);
    if (!before.contains(pair_of(closure))) state_.newly_closed.insert(closure.to_submap);
  }
}

/// What a submap is to be compared with: the nearest within reach, and those that look like it.
std::vector<LoopCandidate> LoopCloser::untried_for(SubmapId newer,
                                                   std::span<SubmapRecord> submaps) {
  LoopCandidates candidates = candidates_for(submaps, newer, options_, [&](SubmapId older) {
    return state_.standing.contains({newer, older});
  });
  std::vector<LoopCandidate>& untried = candidates.near;
  std::erase_if(untried, [&](const LoopCandidate& candidate) { return was_tried(candidate); });
  if (untried.size() > static_cast<std::size_t>(options_.candidates_max))
    untried.erase(untried.begin() + options_.candidates_max, untried.end());
  const std::size_t near = untried.size();
  for (const LoopCandidate& alike :
       most_alike(submaps, newer, candidates.far, options_.places_max)) {
    const bool is_near =
        std::any_of(untried.begin(), untried.begin() + static_cast<std::ptrdiff_t>(near),
                    [&](const LoopCandidate& other) { return other.older == alike.older; });
    if (!is_near && !was_tried(alike)) untried.push_back(alike);
  }
  for (const LoopCandidate& anywhere : by_appearance(submaps, candidates.adrift)) {
    if (!was_tried(anywhere)) untried.push_back(anywhere);
  }
  return std::move(untried);
}

bool LoopCloser::was_tried(const LoopCandidate& candidate) const {
  if (candidate.by_appearance) return state_.tried_by_appearance.contains(pair_of(candidate));
  const auto tried = state_.tried.find(pair_of(candidate));
  if (tried == state_.tried.end()) return false;
  const Pose2 change = tried->second.inverse() * candidate.older_T_newer;
  return hypotenuse(change.x, change.y) < kLoopCloser.same_try_m &&
         std::abs(change.yaw) < kLoopCloser.same_try_rad;
}

void LoopCloser::note_tried(const LoopCandidate& candidate) {
  if (candidate.by_appearance) {
    state_.tried_by_appearance.insert(pair_of(candidate));
  } else {
    state_.tried[pair_of(candidate)] = candidate.older_T_newer;
  }
}

std::vector<LoopClosure> LoopCloser::close_newest(std::span<SubmapRecord> submaps) {
  return close({submaps.size() - 1}, submaps);
}

std::vector<LoopClosure> LoopCloser::close(SubmapId newest, std::span<SubmapRecord> submaps) {
  const std::vector<LoopCandidate> candidates = untried_for(newest, submaps);
  // Where a drive is to be found, every place is asked: another one may look the same.
  const Drives drives(submaps);
  const bool asks_all = std::ranges::any_of(candidates, [&](const LoopCandidate& candidate) {
    return drives.are_adrift(candidate.older, newest);
  });
  std::vector<LoopClosure> closures;
  std::vector<bool> seen(submaps[newest.index].surface_count());
  for (std::size_t first = 0; first < candidates.size(); first += kLoopCloser.beside) {
    const std::size_t count = std::min(kLoopCloser.beside, candidates.size() - first);
    for (LoopClosure& closure : compare(std::span(candidates).subspan(first, count), submaps)) {
      // Of several poses perhaps another one is right.
      if (closure.state == ClosureState::kWaiting && !closure.second_score)
        add_to(seen, state_.seen.at(pair_of(closure)));
      closures.push_back(closure);
    }
    if (!asks_all && share_of(seen) >= kLoopCloser.covered) break;
  }
  reject_rivals(closures, submaps);
  return closures;
}

std::vector<LoopClosure> LoopCloser::close_all(std::span<SubmapRecord> submaps,
                                               const std::function<bool()>& goes_on) {
  std::vector<LoopCandidate> candidates;
  for (std::size_t newer = 1; newer < submaps.size(); ++newer) {
    const auto more = untried_for({newer}, submaps);
    candidates.insert(candidates.end(), more.begin(), more.end());
  }
  std::vector<LoopClosure> closures;
  for (std::size_t first = 0; first < candidates.size() && (!goes_on || goes_on());
       first += kLoopCloser.at_once) {
    const std::size_t count = std::min(kLoopCloser.at_once, candidates.size() - first);
    auto found = compare(std::span(candidates).subspan(first, count), submaps);
    std::move(found.begin(), found.end(), std::back_inserter(closures));
  }
  reject_rivals(closures, submaps);
  return closures;
}

/// A submap can't be at two places. Where one found by appearance is contradicted by another
/// closure of the same submap, nobody knows which is right.
void LoopCloser::reject_rivals(std::vector<LoopClosure>& closures,
                               std::span<const SubmapRecord> submaps) const {
  std::vector<std::size_t> rejected;
  const Drives drives(submaps);
  for (std::size_t i = 0; i < closures.size(); ++i) {
    const LoopClosure& a = closures[i];
    const bool is_adrift = drives.are_adrift(a.from_submap, a.to_submap);
    if (a.state != ClosureState::kWaiting || !a.by_appearance) continue;
    for (const LoopClosure& b : closures) {
      if (b.state != ClosureState::kWaiting || b.to_submap != a.to_submap) continue;
      const SubmapRecord& of_a = submaps[a.from_submap.index];
      const SubmapRecord& of_b = submaps[b.from_submap.index];
      const double between_m = is_adrift ? 0.0 : std::abs(of_a.travelled_m - of_b.travelled_m);
      const Pose2 apart =
          (of_a.map_T_submap * a.from_T_to).inverse() * (of_b.map_T_submap * b.from_T_to);
      if (hypotenuse(apart.x, apart.y) > kLoopCloser.elsewhere_m + options_.drift_per_m * between_m)
        rejected.push_back(i);
    }
  }
  for (const std::size_t i : rejected) {
    closures[i].state = ClosureState::kRejected;
    closures[i].reason = ClosureReason::kAmbiguousPlace;
  }
}

std::vector<LoopClosure> LoopCloser::compare(std::span<const LoopCandidate> candidates,
                                             std::span<const SubmapRecord> submaps) {
  for (const LoopCandidate& candidate : candidates) note_tried(candidate);
  std::vector<std::optional<VerifiedClosure>> verified(candidates.size());
  parallel_for(candidates.size(), threads_, [&](std::size_t i) {
    verified[i] = verify(candidates[i], *submaps[candidates[i].older.index].frozen,
                         *submaps[candidates[i].newer.index].frozen, options_, submap_options_,
                         match_options_);
  });
  std::vector<LoopClosure> closures;
  for (auto& found : verified) {
    if (!found) continue;
    if (found->closure.state == ClosureState::kWaiting)
      state_.seen[pair_of(found->closure)] = std::move(found->seen);
    closures.push_back(found->closure);
  }
  return closures;
}

std::vector<SubmapId> LoopCloser::drop_covered(std::span<SubmapRecord> submaps, bool forgets) {
  const auto is_dropped = [&](SubmapId submap) {
    return submaps[submap.index].state == SubmapState::kDropped;
  };
  std::vector<SubmapId> dropped;
  for (const SubmapId newer : std::exchange(state_.newly_closed, {})) {
    SubmapRecord& submap = submaps[newer.index];
    if (is_dropped(newer)) continue;
    std::vector<bool> seen(submap.surface_count());
    for (const SubmapId older : submap.closed_with) {
      if (older > newer || is_dropped(older)) continue;
      const auto known = state_.seen.find({newer, older});
      if (known != state_.seen.end()) add_to(seen, known->second);
    }
    if (!(share_of(seen) >= kLoopCloser.covered)) continue;
    submap.drop();
    if (forgets) {
      state_.seen.erase(state_.seen.lower_bound({newer, {0}}),
                        state_.seen.lower_bound({{newer.index + 1}, {0}}));
    }
    dropped.push_back(newer);
  }
  return dropped;
}

void LoopCloser::drop_all(std::span<SubmapRecord> submaps) {
  for (SubmapRecord& submap : submaps) submap.drop();
  state_.seen.clear();
}

bool is_sound(const LoopCloser::State& state, std::span<const SubmapRecord> submaps) {
  const auto exists = [&](SubmapId submap) { return submap.index < submaps.size(); };
  const auto both_exist = [&](const SubmapPair& pair) {
    return exists(pair.newer) && exists(pair.older);
  };
  const auto fits = [&](const auto& seen) {
    // Of a submap that was dropped the surfaces are gone.
    if (!both_exist(seen.first)) return false;
    const SubmapRecord& newer = submaps[seen.first.newer.index];
    return newer.state == SubmapState::kDropped || seen.second.size() == newer.surface_count();
  };
  return std::ranges::all_of(state.standing, both_exist) &&
         std::ranges::all_of(state.tried,
                             [&](const auto& tried) { return both_exist(tried.first); }) &&
         std::ranges::all_of(state.tried_by_appearance, both_exist) &&
         std::ranges::all_of(state.seen, fits) && std::ranges::all_of(state.newly_closed, exists);
}

}  // namespace loopstone
