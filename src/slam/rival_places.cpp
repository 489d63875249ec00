#include "slam/rival_places.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "loopstone/graph/marginals.hpp"
#include "loopstone/registration/correlative_search.hpp"
#include "slam/drives.hpp"
#include "slam/loop_candidates.hpp"
#include "slam/loop_coverage.hpp"
#include "slam/loop_surroundings.hpp"
#include "slam/loop_verification.hpp"
#include "slam/placement.hpp"
#include "slam/scan_edges.hpp"

namespace loopstone {

namespace {

double widest_m(const Eigen::Matrix3d& covariance) {
  return largest_sigma(covariance.topLeftCorner<2, 2>());
}

/// How unlikely a motion is for the path.
double chi2_of(const Pose2& motion, const Pose2& expected, const Eigen::Matrix3d& covariance) {
  const Eigen::Vector3d off(motion.x - expected.x, motion.y - expected.y,
                            wrap_angle(motion.yaw - expected.yaw));
  return off.dot(solve_symmetric(covariance, off));
}

/// What a pose must reach to be a place.
struct Bar {
  double score;
  double overlap;
  double agreement;
};

/// A submap's pose in a place, other than the one left out, if it fits there.
std::optional<Pose2> fitted(const FrozenSubmap& place, const FrozenSubmap& newer,
                            const SearchWindow& window, const ExcludedPoses& left_out,
                            const Bar& bar, const SubmapOptions& submap_options,
                            const GridMatchOptions& match_options) {
  const MaxPyramid cells = place.search_pyramid(submap_options, window.half_xy_m);
  const SearchResult best = search_branch_and_bound(newer.probe(kRivalPlaces.probe_points), cells,
                                                    window, bar.score, left_out);
  if (!best.found) return {};
  const MatchResult match = match_to_grid(newer.surfaces, place.surface_grid(submap_options),
                                          best.target_T_source, {}, match_options, 0);
  const double overlap = share_of(seen_by(cells, match.target_T_source, newer.surfaces));
  if (match.status == MatchStatus::kTooFewPairs || overlap < bar.overlap ||
      match.score < bar.agreement * overlap)
    return {};
  return match.target_T_source;
}

/// How well a closure agrees with the place that it found, by the surfaces of both submaps.
class FoundAgreement {
 public:
  FoundAgreement(const LoopClosure& closure, const SubmapRecord& older, const SubmapRecord& newer,
                 const SubmapOptions& options)
      : closure_(closure), older_(older), newer_(newer), options_(options) {}

  /// Whether the newer submap agrees with another place nearly as well.
  [[nodiscard]] bool is_reached_by(const SubmapRecord& place, const Pose2& map_T_newer) {
    if (!found_) found_ = in(older_, closure_.from_T_to);  // once a rival asks
    return in(place, place.map_T_submap.inverse() * map_T_newer) >=
           kLoopVerification.rival_agreement * *found_;
  }

 private:
  [[nodiscard]] double in(const SubmapRecord& place, const Pose2& place_T_newer) const {
    return agreement_of(*place.frozen, *newer_.frozen, place_T_newer, options_);
  }

  const LoopClosure& closure_;
  const SubmapRecord& older_;
  const SubmapRecord& newer_;
  const SubmapOptions& options_;
  std::optional<double> found_{};
};

}  // namespace

std::vector<Eigen::Matrix3d> known_motions(const PoseGraph& graph,
                                           std::span<const LoopClosure> closures) {
  std::vector<std::pair<NodeId, NodeId>> pairs;
  for (const LoopClosure& closure : closures)
    pairs.emplace_back(NodeId{static_cast<int>(closure.from_submap.index)},
                       NodeId{static_cast<int>(closure.to_submap.index)});
  const PairMarginals marginals = joint_covariances(graph, pairs);
  std::vector<Eigen::Matrix3d> known;
  if (!marginals.available) return known;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto pose = [&](NodeId node) {
      return graph.poses[static_cast<std::size_t>(node.index)];
    };
    known.push_back(
        relative_covariance(pose(pairs[i].first), pose(pairs[i].second), marginals.covariances[i]));
  }
  return known;
}

bool is_likely(const LoopClosure& closure, const Eigen::Matrix3d& known, double travel_m,
               std::span<const SubmapRecord> submaps) {
  const Pose2 present = submaps[closure.from_submap.index].map_T_submap.inverse() *
                        submaps[closure.to_submap.index].map_T_submap;
  const double drift_m = kLoopCandidates.rest_m + kRivalPlaces.drift_per_m * travel_m;
  const double drift_rad = kLoopCandidates.rest_rad + kRivalPlaces.drift_rad_per_m * travel_m;
  const Eigen::Matrix3d covariance =
      known + closure.covariance + planar_covariance(drift_m, drift_rad);
  const double most =
      closure.second_score ? kRivalPlaces.ambiguous_chi2 : kRivalPlaces.unlikely_chi2;
  return chi2_of(closure.from_T_to, present, covariance) <= most;
}

namespace {

/// Another place for what a closure lays.
struct Rival {
  Pose2 moved;        ///< what lays it there, map frame
  Pose2 map_T_newer;  ///< the closure's newer submap there
  bool was_seen;      ///< else somewhere that nobody saw
};

/// Where else a closure's submaps fit.
class RivalSearch {
 public:
  RivalSearch(const AskedClosure& asked, std::span<const SubmapRecord> submaps,
              const LoopOptions& options, const SubmapOptions& submap_options,
              const GridMatchOptions& match_options)
      : asked_(asked),
        submaps_(submaps.first(asked.closure.to_submap.index)),
        older_(submaps[asked.closure.from_submap.index]),
        newer_(submaps[asked.closure.to_submap.index]),
        options_(options),
        submap_options_(submap_options),
        match_options_(match_options),
        present_(older_.map_T_submap.inverse() * newer_.map_T_submap),
        map_T_found_(older_.map_T_submap * asked.closure.from_T_to),
        most_chi2_(chi2_of(asked.closure.from_T_to, present_, asked.known) +
                   kRivalPlaces.lead_chi2),
        half_m_(
            std::min(options.max_half_xy_m, kRivalPlaces.window_sigmas * widest_m(asked.known))),
        // What repeats itself stands side by side mostly, and faces the same way; but where the
        // path does not know the heading, a room may be its own mirror.
        half_rad_(std::clamp(kRivalPlaces.window_sigmas * std::sqrt(asked.known(2, 2)),
                             kRivalPlaces.half_rad, kPi)) {}

  /// Whether the path leads there as well.
  [[nodiscard]] bool is_near(const Pose2& map_T_newer) const {
    return chi2_of(older_.map_T_submap.inverse() * map_T_newer, present_, asked_.known) <
           most_chi2_;
  }
  /// Places before the break where the newer submap fits as well.
  [[nodiscard]] std::vector<Rival> seen() const {
    const LoopClosure& closure = asked_.closure;
    const Bar bar{std::max(options_.min_score, kRivalPlaces.score_share * closure.score),
                  options_.min_overlap, options_.min_agreement};
    const Pose2 expected{newer_.map_T_submap.x, newer_.map_T_submap.y, map_T_found_.yaw};
    FoundAgreement agreement(closure, older_, newer_, submap_options_);
    std::vector<Rival> rivals;
    for (const SubmapRecord& place : submaps_) {
      const auto rival = fits(place, newer_, expected, map_T_found_, bar);
      if (rival && is_near(*rival) && agreement.is_reached_by(place, *rival))
        rivals.push_back({*rival * map_T_found_.inverse(), *rival, true});
    }
    return rivals;
  }
  /// Where the older place repeats itself, the next repetition may be one that nobody saw yet.
  [[nodiscard]] std::vector<Rival> repeated() const {
    const LoopClosure& closure = asked_.closure;
    const Bar bar{std::max(options_.min_score, kRivalPlaces.again_share * closure.score),
                  kRivalPlaces.again_overlap, kRivalPlaces.again_share * closure.agreement};
    const Pose2& map_T_older = older_.map_T_submap;
    std::vector<Rival> rivals;
    for (const SubmapRecord& place : submaps_) {
      if (&place == &older_) continue;
      const auto again = fits(place, older_, map_T_older, map_T_older, bar);
      if (!again) continue;
      const Pose2 step = *again * map_T_older.inverse();
      for (const Pose2& moved : {step, step.inverse()}) {
        if (is_near(moved * map_T_found_)) rivals.push_back({moved, moved * map_T_found_, false});
      }
    }
    return rivals;
  }

 private:
  /// Where a submap that lies at `expected` fits into a place, but for `left_out`.
  [[nodiscard]] std::optional<Pose2> fits(const SubmapRecord& place, const SubmapRecord& submap,
                                          const Pose2& map_T_expected, const Pose2& map_T_left_out,
                                          const Bar& bar) const {
    if (place.surface_count() == 0 || place.piece == newer_.piece) return {};
    const Pose2 place_T_map = place.map_T_submap.inverse();
    const Pose2 expected = place_T_map * map_T_expected;
    if ((expected * submap.centre - place.centre).norm() >
        kRivalPlaces.near_radii * (place.radius_m + submap.radius_m) + half_m_)
      return {};
    const ExcludedPoses left_out{place_T_map * map_T_left_out, kLoopVerification.elsewhere_m,
                                 kLoopVerification.elsewhere_rad};
    const auto found = fitted(*place.frozen, *submap.frozen, {expected, half_m_, half_rad_},
                              left_out, bar, submap_options_, match_options_);
    if (!found) return {};
    return place.map_T_submap * *found;
  }

  const AskedClosure& asked_;
  std::span<const SubmapRecord> submaps_;  // before the newer one
  const SubmapRecord& older_;
  const SubmapRecord& newer_;
  const LoopOptions& options_;
  const SubmapOptions& submap_options_;
  const GridMatchOptions& match_options_;
  Pose2 present_;
  Pose2 map_T_found_;
  double most_chi2_;
  double half_m_;
  double half_rad_;
};

/// Of closures that share an end, the best scored: it stands for them.
template <typename End>
std::vector<const AskedClosure*> best_by(std::span<const AskedClosure* const> asked, End&& end) {
  std::map<SubmapId, const AskedClosure*> best;
  for (const AskedClosure* one : asked) {
    const auto [at, is_new] = best.try_emplace(end(one->closure), one);
    if (!is_new && one->closure.score > at->second->closure.score) at->second = one;
  }
  std::vector<const AskedClosure*> found;
  for (const auto& [submap, one] : best) found.push_back(one);
  return found;
}

/// It may still be right.
bool names_a_place(const LoopClosure& closure) {
  return closure.state == ClosureState::kWaiting ||
         (closure.state == ClosureState::kRejected &&
          closure.reason == ClosureReason::kAmbiguousPlace);
}

std::vector<Rival> each_once(std::span<const std::vector<Rival>> found) {
  std::vector<Rival> rivals;
  for (const auto& some : found) {
    for (const Rival& rival : some) {
      const auto is_same = [&](const Rival& other) {
        const Pose2 there = other.moved * rival.moved.inverse() * rival.map_T_newer;
        return other.was_seen == rival.was_seen &&
               !is_elsewhere(there, rival.map_T_newer, kRivalPlaces.same_share);
      };
      if (std::ranges::none_of(rivals, is_same)) rivals.push_back(rival);
    }
  }
  return rivals;
}

/// What is asked about a placement, and by what means.
class PlaceQuestion {
 public:
  PlaceQuestion(const Placement& placement, std::span<const SubmapRecord> submaps,
                const LoopOptions& options, const SubmapOptions& submap_options,
                const GridMatchOptions& match_options, Threads threads)
      : placement_(placement),
        submaps_(submaps),
        options_(options),
        submap_options_(submap_options),
        match_options_(match_options),
        threads_(threads) {}

  /// Other places, each once.
  [[nodiscard]] std::vector<Rival> rivals(std::span<const LoopClosure> all) const {
    const auto asked = placement_.asked();
    const auto newer = best_by(asked, [](const LoopClosure& one) { return one.to_submap; });
    const auto older = best_by(asked, [](const LoopClosure& one) { return one.from_submap; });
    std::vector<std::vector<Rival>> found(newer.size() + older.size());
    parallel_for(found.size(), threads_, [&](std::size_t i) {
      found[i] =
          i < newer.size() ? search(*newer[i]).seen() : search(*older[i - newer.size()]).repeated();
    });
    found.push_back(named_by(all));
    return each_once(found);
  }

  /// How well what lies behind the break agrees with what lay before, as the closures lay it and
  /// where each rival would.
  [[nodiscard]] std::vector<SurfaceFit> agreement(std::span<const Rival> rivals) const {
    std::vector<Witness> witnesses;
    for (const SubmapId submap : placement_.witnesses())
      witnesses.push_back({&submaps_[submap.index], placement_.map_T_submap(submap),
                           SubmapTarget(*submaps_[submap.index].frozen, submap_options_, 0.0)});
    std::vector<Pose2> moves{Pose2{}};
    for (const Rival& rival : rivals) moves.push_back(rival.moved);
    const auto before =
        submaps_.first(static_cast<std::size_t>(witnesses.front().submap - submaps_.data()));
    std::vector<std::vector<SurfaceFit>> by_place(before.size());
    parallel_for(before.size(), threads_,
                 [&](std::size_t i) { by_place[i] = told_of(before[i], witnesses, moves); });
    std::vector<SurfaceFit> sums(moves.size());
    for (const auto& fits : by_place) {
      for (std::size_t i = 0; i < fits.size(); ++i) sums[i] += fits[i];
    }
    return sums;
  }

  /// How well submaps of one piece agree, about both ends.
  [[nodiscard]] SurfaceFit usual_agreement() const {
    std::set<std::size_t> first_ones;
    for (const AskedClosure* one : placement_.asked()) {
      for (const SubmapId end : {one->closure.from_submap, one->closure.to_submap}) {
        const std::size_t first = end.index - std::min(end.index, kLoopSurroundings.reach);
        for (std::size_t i = first; i <= end.index; ++i) first_ones.insert(i);
      }
    }
    std::vector<std::pair<std::size_t, std::size_t>> pairs;
    for (const std::size_t a : first_ones) {
      const std::size_t last = std::min(a + kLoopSurroundings.reach, submaps_.size() - 1);
      for (std::size_t b = a + kLoopSurroundings.beside + 1; b <= last; ++b) {
        if (are_of_one_place(submaps_[a], submaps_[b])) pairs.emplace_back(a, b);
      }
    }
    std::vector<SurfaceFit> fits(pairs.size());
    parallel_for(pairs.size(), threads_, [&](std::size_t i) {
      const SubmapRecord& a = submaps_[pairs[i].first];
      const SubmapRecord& b = submaps_[pairs[i].second];
      fits[i] = fit_of(*a.frozen, *b.frozen, a.map_T_submap.inverse() * b.map_T_submap, kAll,
                       submap_options_, match_options_);
      fits[i] *= shares_of(a, b);
    });
    SurfaceFit sum;
    for (const SurfaceFit& fit : fits) sum += fit;
    return sum;
  }

 private:
  static constexpr double kAll = std::numeric_limits<double>::infinity();

  struct Witness {
    const SubmapRecord* submap;
    Pose2 map_T_found;
    SubmapTarget target;
  };

  [[nodiscard]] RivalSearch search(const AskedClosure& asked) const {
    return {asked, submaps_, options_, submap_options_, match_options_};
  }
  /// Places of other closures.
  [[nodiscard]] std::vector<Rival> named_by(std::span<const LoopClosure> all) const {
    std::vector<Rival> rivals;
    for (const LoopClosure& other : all) {
      if (!names_a_place(other) || !placement_.concerns(other) || placement_.holds(other)) continue;
      const SubmapId there = other.to_submap;
      const Pose2 map_T_there = laid_by(other, there, submaps_);
      const AskedClosure& one = placement_.nearest(there);
      const Pose2 moved = map_T_there * placement_.map_T_submap(there).inverse();
      if (search(one).is_near(moved * placement_.map_T_submap(one.closure.to_submap)))
        rivals.push_back({moved, map_T_there, true});
    }
    return rivals;
  }
  /// What one place says of the witnesses wherever they are moved: shares of both submaps.
  [[nodiscard]] std::vector<SurfaceFit> told_of(const SubmapRecord& place,
                                                std::span<const Witness> witnesses,
                                                std::span<const Pose2> moves) const {
    if (place.surface_count() == 0 || place.piece == witnesses.front().submap->piece) return {};
    std::optional<SubmapTarget> target;  // once one lies there
    std::vector<SurfaceFit> told(moves.size());
    for (std::size_t i = 0; i < moves.size(); ++i) {
      for (const Witness& witness : witnesses) {
        const SubmapRecord& submap = *witness.submap;
        const Pose2 pose = place.map_T_submap.inverse() * moves[i] * witness.map_T_found;
        if ((pose * submap.centre - place.centre).norm() > place.radius_m + submap.radius_m)
          continue;
        if (!target) target.emplace(*place.frozen, submap_options_, kLoopSurroundings.slack_m);
        SurfaceFit fit = fit_of(*place.frozen, *target, *submap.frozen, witness.target, pose, kAll,
                                match_options_);
        fit *= shares_of(place, submap);
        told[i] += fit;
      }
    }
    return told;
  }
  /// Makes a share of the surfaces of both.
  [[nodiscard]] static double shares_of(const SubmapRecord& a, const SubmapRecord& b) {
    return 1.0 / static_cast<double>(a.surface_count() + b.surface_count());
  }
  [[nodiscard]] static bool are_of_one_place(const SubmapRecord& a, const SubmapRecord& b) {
    if (a.piece != b.piece || a.surface_count() == 0 || b.surface_count() == 0) return false;
    const Eigen::Vector2d apart = a.map_T_submap * a.centre - b.map_T_submap * b.centre;
    return apart.norm() <= a.radius_m + b.radius_m;
  }

  const Placement& placement_;
  std::span<const SubmapRecord> submaps_;
  const LoopOptions& options_;
  const SubmapOptions& submap_options_;
  const GridMatchOptions& match_options_;
  Threads threads_;
};

/// One for each place where closures lay what the path does not know well.
std::vector<Placement> placements_of(std::span<const AskedClosure> asked,
                                     std::span<const SubmapRecord> submaps) {
  std::vector<Placement> placements;
  for (const AskedClosure& one : asked) {
    const SubmapRecord& newer = submaps[one.closure.to_submap.index];
    const SubmapRecord& older = submaps[one.closure.from_submap.index];
    const bool is_known = widest_m(one.known) <= kRivalPlaces.wide_m &&
                          std::sqrt(one.known(2, 2)) <= kRivalPlaces.wide_rad;
    if (older.piece == newer.piece || is_known || newer.surface_count() == 0 ||
        older.surface_count() == 0)
      continue;
    const auto at = std::ranges::find_if(placements, [&](const Placement& placement) {
      return placement.concerns(one.closure) && placement.holds(one.closure);
    });
    if (at == placements.end()) {
      placements.emplace_back(submaps, one);
    } else {
      at->add(one);
    }
  }
  return placements;
}

/// Somebody may have put the robot down anywhere around, facing any way.
bool knows_nothing_of(const AskedClosure* one) {
  return widest_m(one->known) > kLoopVerification.elsewhere_m &&
         std::sqrt(one->known(2, 2)) > kRivalPlaces.any_rad;
}

}  // namespace

std::vector<bool> have_rival_places(std::span<const AskedClosure> asked,
                                    std::span<const LoopClosure> all,
                                    std::span<const SubmapRecord> submaps,
                                    const LoopOptions& options, const SubmapOptions& submap_options,
                                    const GridMatchOptions& match_options, Threads threads) {
  std::vector<bool> have(asked.size());
  for (const Placement& placement : placements_of(asked, submaps)) {
    const PlaceQuestion question(placement, submaps, options, submap_options, match_options,
                                 threads);
    const std::vector<Rival> rivals = question.rivals(all);
    const bool may_be_anywhere = std::ranges::any_of(placement.asked(), knows_nothing_of);
    if (rivals.empty() && !may_be_anywhere) continue;
    const std::vector<SurfaceFit> fits = question.agreement(rivals);
    const double found = fits.front().share();
    const auto agrees_nearly_as_well = [&](const SurfaceFit& there) {
      return there.on >= (found - kRivalPlaces.clearly_less) * there.seen();
    };
    const auto agrees_less_than_usual = [&] {
      return found < question.usual_agreement().share() - kRivalPlaces.clearly_less;
    };
    const bool is_ambiguous =
        std::any_of(fits.begin() + 1, fits.end(), agrees_nearly_as_well) ||
        ((may_be_anywhere || !std::ranges::all_of(rivals, &Rival::was_seen)) &&
         agrees_less_than_usual());
    for (const AskedClosure* one : placement.asked())
      have[static_cast<std::size_t>(one - asked.data())] = is_ambiguous;
  }
  return have;
}

bool repeats_itself(const LoopClosure& closure, std::span<const SubmapRecord> submaps,
                    const LoopOptions& options, const SubmapOptions& submap_options,
                    const GridMatchOptions& match_options) {
  const SubmapRecord& older = submaps[closure.from_submap.index];
  if (!older.frozen) return false;
  const Drives drives(submaps);
  const Bar bar{std::max(options.min_score, kRivalPlaces.again_share * closure.score),
                kRivalPlaces.again_overlap, kRivalPlaces.again_share * closure.agreement};
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    const SubmapRecord& place = submaps[i];
    if (i == closure.from_submap.index || place.surface_count() == 0 ||
        drives.are_adrift({i}, closure.from_submap))
      continue;
    const Pose2 place_T_older = place.map_T_submap.inverse() * older.map_T_submap;
    const Eigen::Vector2d shift =
        place.centre - Pose2{0.0, 0.0, place_T_older.yaw}.rotation() * older.centre;
    const SearchWindow anywhere{
        {shift.x(), shift.y(), place_T_older.yaw}, kLoopCandidates.place_half_m, kPi};
    const ExcludedPoses itself{place_T_older, kLoopVerification.elsewhere_m,
                               kLoopVerification.elsewhere_rad};
    if (fitted(*place.frozen, *older.frozen, anywhere, itself, bar, submap_options, match_options))
      return true;
  }
  return false;
}

}  // namespace loopstone
