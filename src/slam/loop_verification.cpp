#include "slam/loop_verification.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include "loopstone/geometry/pose2.hpp"
#include "registration/lattice_search.hpp"
#include "slam/loop_coverage.hpp"
#include "slam/loop_surroundings.hpp"

namespace loopstone {

namespace {

/// What a closure must reach.
struct Bar {
  double score;
  double overlap;
  double agreement;
};

Bar bar_for(const LoopCandidate& candidate, const LoopOptions& options) {
  const Bar asked{options.min_score, options.min_overlap, options.min_agreement};
  if (!candidate.by_appearance) return asked;
  return {std::max(asked.score, kLoopVerification.appearance_score),
          std::max(asked.overlap, kLoopVerification.appearance_overlap),
          std::max(asked.agreement, kLoopVerification.appearance_agreement)};
}

/// A pose elsewhere in the window that scores nearly as well as the best.
std::optional<SearchResult> rival_of(LatticeSearch& search, const SearchWindow& window,
                                     const SearchResult& best, double max_ambiguity) {
  // In a small window there is no elsewhere.
  const bool wide = window.half_xy_m > 0.5 * kLoopVerification.elsewhere_m ||
                    window.half_yaw_rad > 0.5 * kLoopVerification.elsewhere_rad;
  if (!wide) return {};
  const SearchResult second = search.best(
      max_ambiguity * best.score, ExcludedPoses{best.target_T_source, kLoopVerification.elsewhere_m,
                                                kLoopVerification.elsewhere_rad});
  if (!second.found) return {};
  return second;
}

/// How well two submaps agree, by two measures: the share of the overlap that matches, to which the
/// other side of a thin wall is a contradiction, and the share of each one's surfaces that lies on
/// the other's where that one looked.
/// \param two_sided  the latter, if it was asked
double agreement_by(const LoopCandidate& candidate, double overlap, double matched,
                    std::optional<double> two_sided) {
  const double of_overlap = overlap > 0.0 ? std::min(1.0, matched / overlap) : 0.0;
  if (!two_sided) return of_overlap;
  const double of_both = std::min(1.0, *two_sided + kLoopVerification.stricter);
  // Behind a break the path says little, and what repeats itself overlaps well.
  if (candidate.across_break && !candidate.by_appearance) return of_both;
  return std::max(of_overlap, of_both);
}

ClosureReason judge(const LoopClosure& closure, const MatchResult& match, const Bar& bar) {
  if (match.status == MatchStatus::kTooFewPairs) return ClosureReason::kTooFewPairs;
  // Which of several poses is right the path may know, unless it led nowhere near.
  if (closure.second_score && closure.by_appearance) return ClosureReason::kAmbiguousPose;
  if (closure.overlap < bar.overlap) return ClosureReason::kTooLittleOverlap;
  if (closure.agreement < bar.agreement) return ClosureReason::kSurfacesDisagree;
  return ClosureReason::kWaitsForSecond;
}

std::optional<VerifiedClosure> verify_one_way(const LoopCandidate& candidate,
                                              const FrozenSubmap& older, const FrozenSubmap& newer,
                                              const LoopOptions& options,
                                              const SubmapOptions& submap_options,
                                              const GridMatchOptions& match_options) {
  const auto probe = newer.probe(kLoopVerification.probe_points);
  if (probe.empty() || older.surfaces.empty()) return {};
  const Bar bar = bar_for(candidate, options);
  const MaxPyramid pyramid = older.search_pyramid(submap_options, candidate.half_xy_m);
  const SearchWindow window{candidate.older_T_newer, candidate.half_xy_m, candidate.half_yaw_rad};
  LatticeSearch search(probe, pyramid, window);
  const SearchResult best = search.best(bar.score);
  if (!best.found) return {};
  const SurfaceGrid surfaces = older.surface_grid(submap_options);
  const auto refined = [&](const SearchResult& found) {
    return match_to_grid(newer.surfaces, surfaces, found.target_T_source, {}, match_options, 0);
  };
  const MatchResult match = refined(best);

  const SubmapGrids on_older{pyramid, surfaces};
  VerifiedClosure verified{.closure = {},
                           .seen = shown_by(on_older, match.target_T_source, newer.surfaces)};
  LoopClosure& closure = verified.closure;
  closure.from = NodeId{static_cast<int>(candidate.older.index)};
  closure.to = NodeId{static_cast<int>(candidate.newer.index)};
  closure.from_submap = candidate.older;
  closure.to_submap = candidate.newer;
  closure.from_T_to = match.target_T_source;
  closure.covariance = match.covariance;
  const double bend_m2 = kLoopVerification.bend_m * kLoopVerification.bend_m;
  const double bend_rad2 = kLoopVerification.bend_rad * kLoopVerification.bend_rad;
  closure.covariance.diagonal() += Eigen::Vector3d(bend_m2, bend_m2, bend_rad2);
  closure.by_appearance = candidate.by_appearance;
  closure.score = best.score;
  closure.overlap = share_of(seen_by(pyramid, match.target_T_source, newer.surfaces));
  const auto agreement_at = [&](const Pose2& pose) {
    return agreement_of(older, on_older, newer, pose, submap_options);
  };
  std::optional<double> two_sided;
  if (candidate.across_break || !candidate.by_appearance)
    two_sided = agreement_at(match.target_T_source);
  closure.agreement = agreement_by(candidate, closure.overlap, match.score, two_sided);
  const auto disagrees = [&](const SearchResult& found) {
    return agreement_at(refined(found).target_T_source) <
           kLoopVerification.rival_agreement * *two_sided;
  };
  const auto rival = rival_of(search, window, best, options.max_ambiguity);
  if (rival && !(candidate.across_break && disagrees(*rival))) closure.second_score = rival->score;
  closure.reason = judge(closure, match, bar);
  if (closure.reason == ClosureReason::kWaitsForSecond) closure.state = ClosureState::kWaiting;
  return verified;
}

/// Centre on centre stays so; any heading is any heading.
LoopCandidate turned_round(LoopCandidate candidate) {
  std::swap(candidate.older, candidate.newer);
  candidate.older_T_newer = candidate.older_T_newer.inverse();
  return candidate;
}

/// What was found of the older submap in the newer one, as said of the newer in the older.
void turn_round(const FrozenSubmap& older, const FrozenSubmap& newer,
                const SubmapOptions& submap_options, VerifiedClosure& found) {
  LoopClosure& closure = found.closure;
  std::swap(closure.from, closure.to);
  std::swap(closure.from_submap, closure.to_submap);
  const PoseWithCovariance2 turned =
      inverse(PoseWithCovariance2{closure.from_T_to, closure.covariance});
  closure.from_T_to = turned.pose;
  closure.covariance = turned.covariance;
  found.seen =
      shown_by({older.search_pyramid(submap_options, 0.0), older.surface_grid(submap_options)},
               turned.pose, newer.surfaces);
}

}  // namespace

std::optional<VerifiedClosure> verify(const LoopCandidate& candidate, const FrozenSubmap& older,
                                      const FrozenSubmap& newer, const LoopOptions& options,
                                      const SubmapOptions& submap_options,
                                      const GridMatchOptions& match_options) {
  auto found = verify_one_way(candidate, older, newer, options, submap_options, match_options);
  const bool may_be_larger = !found || found->closure.reason == ClosureReason::kTooLittleOverlap;
  if (!may_be_larger || !candidate.either_way) return found;
  auto other =
      verify_one_way(turned_round(candidate), newer, older, options, submap_options, match_options);
  if (!other || other->closure.state != ClosureState::kWaiting) return found;
  turn_round(older, newer, submap_options, *other);
  return other;
}

}  // namespace loopstone
