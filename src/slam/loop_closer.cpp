#include "loopstone/slam/loop_closer.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "loopstone/slam/key_chain.hpp"
#include "slam/loop_candidates.hpp"
#include "slam/loop_coverage.hpp"
#include "slam/loop_verification.hpp"

namespace loopstone {

namespace {

/// A pair that failed is tried again once its poses have changed by this much.
constexpr double kSameTryM = 0.25;
constexpr double kSameTryRad = 0.03;
/// Two closures of one submap that put it this far apart speak of two places.
constexpr double kElsewhereM = 1.0;
/// A submap of which older ones saw so much adds nothing.
constexpr double kCovered = 0.9;
/// So many are compared beside each other, whatever the number of threads; the nearest first, until
/// the submap is covered.
constexpr std::size_t kBeside = 2;
/// In the end so many, some tenths of a second, before somebody is asked whether to go on.
constexpr std::size_t kAtOnce = 64;

SubmapPair pair_of(const LoopClosure& closure) { return {closure.to_submap, closure.from_submap}; }
SubmapPair pair_of(const LoopCandidate& candidate) { return {candidate.newer, candidate.older}; }

}  // namespace

LoopCloser::LoopCloser(const LoopOptions& options, const SubmapOptions& submap,
                       const GridMatchOptions& match, Threads threads)
    : options_(options), submap_options_(submap), match_options_(match), threads_(threads) {}

LoopCloser::~LoopCloser() = default;
LoopCloser::LoopCloser(LoopCloser&&) noexcept = default;
LoopCloser& LoopCloser::operator=(LoopCloser&&) noexcept = default;

template <typename Archive>
void LoopCloser::archive_fields(Archive& a) {
  a(submaps_, standing_, tried_, tried_by_appearance_, seen_, newly_closed_);
}
void LoopCloser::archive(ByteWriter& a) { archive_fields(a); }
void LoopCloser::archive(ByteReader& a) {
  archive_fields(a);
  a.check(is_sound(), "closures of submaps that are not there");
}

/// Whether every submap that is spoken of is there; for what comes from a file.
bool LoopCloser::is_sound() const {
  const auto exists = [this](SubmapId submap) { return submap.index < submaps_.size(); };
  const auto both_exist = [&](const SubmapPair& pair) {
    return exists(pair.newer) && exists(pair.older);
  };
  const auto fits = [&](const auto& seen) {
    // Of a submap that was dropped the surfaces are gone.
    if (!both_exist(seen.first)) return false;
    const LoopSubmap& newer = submaps_[seen.first.newer.index];
    return newer.dropped || seen.second.size() == newer.submap.surfaces.size();
  };
  std::vector<double> travelled_m;
  for (const LoopSubmap& submap : submaps_) travelled_m.push_back(submap.travelled_m);
  return only_grows(travelled_m) && std::ranges::all_of(standing_, both_exist) &&
         std::ranges::all_of(tried_, [&](const auto& tried) { return both_exist(tried.first); }) &&
         std::ranges::all_of(tried_by_appearance_, both_exist) &&
         std::ranges::all_of(seen_, fits) && std::ranges::all_of(newly_closed_, exists) &&
         std::ranges::all_of(submaps_, [&](const LoopSubmap& submap) {
           return std::ranges::all_of(submap.closed_with, exists);
         });
}

bool LoopCloser::submaps_lie_within(double reach_m) const {
  return std::ranges::all_of(
      submaps_, [&](const LoopSubmap& submap) { return submap.submap.lies_within(reach_m); });
}

std::size_t LoopCloser::submap_count() const { return submaps_.size(); }

void LoopCloser::add(FinishedSubmap submap, double travelled_m) {
  submaps_.push_back(loop_submap(std::move(submap), travelled_m));
}

void LoopCloser::set_closures(std::span<const LoopClosure> closures) {
  const auto before = std::exchange(standing_, {});
  for (LoopSubmap& submap : submaps_) submap.closed_with.clear();
  for (const auto& closure : closures) {
    if (!closure.stands()) continue;
    standing_.insert(pair_of(closure));
    submaps_[closure.from_submap.index].closed_with.push_back(closure.to_submap);
    submaps_[closure.to_submap.index].closed_with.push_back(closure.from_submap);
    if (!before.contains(pair_of(closure))) newly_closed_.insert(closure.to_submap);
  }
}

/// What a submap is to be compared with: the nearest within reach, and those that look like it.
std::vector<LoopCandidate> LoopCloser::untried_for(SubmapId newer,
                                                   std::span<const Pose2> map_T_submap) {
  LoopCandidates candidates =
      candidates_for(submaps_, newer, map_T_submap, options_, [&](SubmapId older) {
        return standing_.contains({newer, older});
      });
  std::vector<LoopCandidate>& untried = candidates.near;
  std::erase_if(untried, [&](const LoopCandidate& candidate) { return was_tried(candidate); });
  if (untried.size() > static_cast<std::size_t>(options_.candidates_max))
    untried.erase(untried.begin() + options_.candidates_max, untried.end());
  const std::size_t near = untried.size();
  for (const LoopCandidate& alike :
       most_alike(submaps_, newer, candidates.far, options_.places_max)) {
    const bool is_near =
        std::any_of(untried.begin(), untried.begin() + static_cast<std::ptrdiff_t>(near),
                    [&](const LoopCandidate& other) { return other.older == alike.older; });
    if (!is_near && !was_tried(alike)) untried.push_back(alike);
  }
  return std::move(untried);
}

bool LoopCloser::was_tried(const LoopCandidate& candidate) const {
  if (candidate.by_appearance) return tried_by_appearance_.contains(pair_of(candidate));
  const auto tried = tried_.find(pair_of(candidate));
  if (tried == tried_.end()) return false;
  const Pose2 change = tried->second.inverse() * candidate.older_T_newer;
  return std::hypot(change.x, change.y) < kSameTryM && std::abs(change.yaw) < kSameTryRad;
}

void LoopCloser::note_tried(const LoopCandidate& candidate) {
  if (candidate.by_appearance) {
    tried_by_appearance_.insert(pair_of(candidate));
  } else {
    tried_[pair_of(candidate)] = candidate.older_T_newer;
  }
}

std::vector<LoopClosure> LoopCloser::close_newest(std::span<const Pose2> map_T_submap) {
  const SubmapId newest{submaps_.size() - 1};
  const std::vector<LoopCandidate> candidates = untried_for(newest, map_T_submap);
  std::vector<LoopClosure> closures;
  std::vector<bool> seen(submaps_[newest.index].submap.surfaces.size());
  for (std::size_t first = 0; first < candidates.size(); first += kBeside) {
    const std::size_t count = std::min(kBeside, candidates.size() - first);
    for (LoopClosure& closure : compare(std::span(candidates).subspan(first, count))) {
      if (closure.state == ClosureState::kWaiting) add_to(seen, seen_.at(pair_of(closure)));
      closures.push_back(closure);
    }
    if (share_of(seen) >= kCovered) break;
  }
  reject_rivals(closures, map_T_submap);
  return closures;
}

std::vector<LoopClosure> LoopCloser::close_all(std::span<const Pose2> map_T_submap,
                                               const std::function<bool()>& goes_on) {
  std::vector<LoopCandidate> candidates;
  for (std::size_t newer = 1; newer < submaps_.size(); ++newer) {
    const auto more = untried_for({newer}, map_T_submap);
    candidates.insert(candidates.end(), more.begin(), more.end());
  }
  std::vector<LoopClosure> closures;
  for (std::size_t first = 0; first < candidates.size() && (!goes_on || goes_on());
       first += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, candidates.size() - first);
    auto found = compare(std::span(candidates).subspan(first, count));
    std::move(found.begin(), found.end(), std::back_inserter(closures));
  }
  reject_rivals(closures, map_T_submap);
  return closures;
}

/// A submap can't be at two places. Where one found by appearance is contradicted by another
/// closure of the same submap, nobody knows which is right.
void LoopCloser::reject_rivals(std::vector<LoopClosure>& closures,
                               std::span<const Pose2> map_T_submap) const {
  std::vector<std::size_t> rejected;
  for (std::size_t i = 0; i < closures.size(); ++i) {
    const LoopClosure& a = closures[i];
    if (a.state != ClosureState::kWaiting || !a.by_appearance) continue;
    for (const LoopClosure& b : closures) {
      if (b.state != ClosureState::kWaiting || b.to_submap != a.to_submap) continue;
      const double between_m = std::abs(submaps_[a.from_submap.index].travelled_m -
                                        submaps_[b.from_submap.index].travelled_m);
      const Pose2 apart = (map_T_submap[a.from_submap.index] * a.from_T_to).inverse() *
                          (map_T_submap[b.from_submap.index] * b.from_T_to);
      if (std::hypot(apart.x, apart.y) > kElsewhereM + options_.drift_per_m * between_m)
        rejected.push_back(i);
    }
  }
  for (const std::size_t i : rejected) {
    closures[i].state = ClosureState::kRejected;
    closures[i].reason = ClosureReason::kAmbiguousPlace;
  }
}

std::vector<LoopClosure> LoopCloser::compare(std::span<const LoopCandidate> candidates) {
  for (const LoopCandidate& candidate : candidates) note_tried(candidate);
  std::vector<std::optional<VerifiedClosure>> verified(candidates.size());
  parallel_for(candidates.size(), threads_, [&](std::size_t i) {
    verified[i] = verify(candidates[i], submaps_[candidates[i].older.index].submap,
                         submaps_[candidates[i].newer.index].submap, options_, submap_options_,
                         match_options_);
  });
  std::vector<LoopClosure> closures;
  for (auto& found : verified) {
    if (!found) continue;
    if (found->closure.state == ClosureState::kWaiting)
      seen_[pair_of(found->closure)] = std::move(found->seen);
    closures.push_back(found->closure);
  }
  return closures;
}

std::vector<SubmapId> LoopCloser::drop_covered() {
  std::vector<SubmapId> dropped;
  for (const SubmapId newer : std::exchange(newly_closed_, {})) {
    LoopSubmap& submap = submaps_[newer.index];
    if (submap.dropped) continue;
    std::vector<bool> seen(submap.submap.surfaces.size());
    for (const SubmapId older : submap.closed_with) {
      if (older > newer || submaps_[older.index].dropped) continue;
      add_to(seen, seen_.at({newer, older}));
    }
    if (!(share_of(seen) >= kCovered)) continue;
    submap.submap = {};
    submap.dropped = true;
    seen_.erase(seen_.lower_bound({newer, {0}}), seen_.lower_bound({{newer.index + 1}, {0}}));
    dropped.push_back(newer);
  }
  return dropped;
}

bool LoopCloser::is_dropped(SubmapId submap) const { return submaps_[submap.index].dropped; }

void LoopCloser::drop_all() {
  for (LoopSubmap& submap : submaps_) {
    submap.submap = {};
    submap.dropped = true;
  }
  seen_.clear();
}

}  // namespace loopstone
