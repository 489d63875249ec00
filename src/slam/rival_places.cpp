#include "slam/rival_places.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
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

/// How much of a submap others show, and how much of that agrees: shares of it, summed over them.
struct Explained {
  double shown = 0.0;
  double fits = 0.0;

  [[nodiscard]] double share() const { return shown > 0.0 ? fits / shown : 0.0; }
};

/// What the submaps before a break of the path say of where one lies.
class BeforeBreak {
 public:
  /// \param after  a submap behind the break
  BeforeBreak(std::span<const SubmapRecord> submaps, SubmapId after,
              const SubmapOptions& submap_options)
      : submaps_(submaps.first(after.index)),
        piece_(submaps[after.index].piece),
        submap_options_(submap_options) {}

  [[nodiscard]] bool has(const SubmapRecord& place) const {
    return place.frozen && !place.frozen->surfaces.empty() && place.piece != piece_;
  }
  /// How all of them explain a submap that would lie there.
  [[nodiscard]] Explained explain(const SubmapRecord& submap, const Pose2& map_T_submap) const {
    Explained sum;
    const auto probe = submap.frozen->probe(kRivalPlaces.probe_points);
    for (const SubmapRecord& place : submaps_) {
      if (!has(place)) continue;
      const Pose2 pose = place.map_T_submap.inverse() * map_T_submap;
      if ((pose * submap.centre - place.centre).norm() > place.radius_m + submap.radius_m) continue;
      const MaxPyramid cells = place.frozen->search_pyramid(submap_options_, kRivalPlaces.slack_m);
      const double shown = share_of(seen_by(cells, pose, submap.frozen->surfaces));
      if (shown < kRivalPlaces.shows_share) continue;
      const SearchResult best = search_branch_and_bound(
          probe, cells, {pose, kRivalPlaces.slack_m, kRivalPlaces.slack_rad}, kLeastScore);
      sum.shown += shown;
      if (best.found) sum.fits += std::min(best.score, shown);
    }
    return sum;
  }

 private:
  static constexpr double kLeastScore = 0.01;  // there is always some pose

  std::span<const SubmapRecord> submaps_;
  std::size_t piece_;
  const SubmapOptions& submap_options_;
};

/// How well a closure agrees with the place that it found, by the surfaces of both submaps.
class FoundAgreement {
 public:
  FoundAgreement(const LoopClosure& closure, std::span<const SubmapRecord> submaps,
                 const SubmapOptions& options)
      : closure_(closure),
        older_(submaps[closure.from_submap.index]),
        newer_(submaps[closure.to_submap.index]),
        options_(options) {}

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

bool has_rival_place(const LoopClosure& closure, const Eigen::Matrix3d& known, bool bends,
                     std::span<const SubmapRecord> submaps, const LoopOptions& options,
                     const SubmapOptions& submap_options, const GridMatchOptions& match_options) {
  const SubmapRecord& newer = submaps[closure.to_submap.index];
  const SubmapRecord& older = submaps[closure.from_submap.index];
  const double wide_m = widest_m(known);
  if (older.piece == newer.piece || wide_m <= kRivalPlaces.wide_m || !newer.frozen || !older.frozen)
    return false;
  const Pose2 map_T_older = older.map_T_submap;
  const Pose2 present = map_T_older.inverse() * newer.map_T_submap;
  const double most_chi2 = chi2_of(closure.from_T_to, present, known) + kRivalPlaces.lead_chi2;
  const double half_m = std::min(options.max_half_xy_m, kRivalPlaces.window_sigmas * wide_m);
  // What repeats itself stands side by side mostly, and faces the same way; but where the path does
  // not know the heading, a room may be its own mirror.
  const double half_rad =
      std::clamp(kRivalPlaces.window_sigmas * std::sqrt(known(2, 2)), kRivalPlaces.half_rad, kPi);
  const Bar as_found{std::max(options.min_score, kRivalPlaces.score_share * closure.score),
                     options.min_overlap, options.min_agreement};
  const Bar as_again{std::max(options.min_score, kRivalPlaces.again_share * closure.score),
                     kRivalPlaces.again_overlap, kRivalPlaces.again_share * closure.agreement};
  // Where a submap that lies at `expected` fits into a place, but for `left_out`.
  const auto fits = [&](const SubmapRecord& place, const SubmapRecord& submap,
                        const Pose2& map_T_expected, const Pose2& map_T_left_out,
                        const Bar& bar) -> std::optional<Pose2> {
    const Pose2 place_T_map = place.map_T_submap.inverse();
    const Pose2 expected = place_T_map * map_T_expected;
    if ((expected * submap.centre - place.centre).norm() >
        kRivalPlaces.near_radii * (place.radius_m + submap.radius_m) + half_m)
      return {};
    const ExcludedPoses left_out{place_T_map * map_T_left_out, kRivalPlaces.elsewhere_m,
                                 kRivalPlaces.elsewhere_rad};
    const auto found = fitted(*place.frozen, *submap.frozen, {expected, half_m, half_rad}, left_out,
                              bar, submap_options, match_options);
    if (!found) return {};
    return place.map_T_submap * *found;
  };
  const BeforeBreak before(submaps, closure.to_submap, submap_options);
  const Pose2 map_T_found = map_T_older * closure.from_T_to;
  std::optional<Explained> found;  // once a rival asks
  const auto is_near = [&](const Pose2& map_T_newer) {
    return chi2_of(map_T_older.inverse() * map_T_newer, present, known) < most_chi2;
  };
  const auto is_explained = [&](const Pose2& map_T_newer) {
    if (!found) found = before.explain(newer, map_T_found);
    const Explained there = before.explain(newer, map_T_newer);
    return there.fits >= (found->share() - kRivalPlaces.clearly_less) * there.shown;
  };
  FoundAgreement agreement(closure, submaps, submap_options);
  for (std::size_t i = 0; i < closure.to_submap.index; ++i) {
    const SubmapRecord& place = submaps[i];
    if (!before.has(place)) continue;
    const Pose2 map_T_expected{newer.map_T_submap.x, newer.map_T_submap.y, map_T_found.yaw};
    const auto rival = fits(place, newer, map_T_expected, map_T_found, as_found);
    if (rival && is_near(*rival) && is_explained(*rival) && agreement.is_reached_by(place, *rival))
      return true;
    // Where the older place repeats itself, the next repetition may be one that nobody saw yet.
    if (!bends || i == closure.from_submap.index) continue;
    const auto again = fits(place, older, map_T_older, map_T_older, as_again);
    if (!again) continue;
    const Pose2 step = *again * map_T_older.inverse();
    if (is_near(step * map_T_found) || is_near(step.inverse() * map_T_found)) return true;
  }
  return false;
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
    if (i == closure.from_submap.index || !place.frozen || place.frozen->surfaces.empty() ||
        drives.are_adrift({i}, closure.from_submap))
      continue;
    const Pose2 place_T_older = place.map_T_submap.inverse() * older.map_T_submap;
    const Eigen::Vector2d shift =
        place.centre - Pose2{0.0, 0.0, place_T_older.yaw}.rotation() * older.centre;
    const SearchWindow anywhere{
        {shift.x(), shift.y(), place_T_older.yaw}, kLoopCandidates.place_half_m, kPi};
    const ExcludedPoses itself{place_T_older, kRivalPlaces.elsewhere_m, kRivalPlaces.elsewhere_rad};
    if (fitted(*place.frozen, *older.frozen, anywhere, itself, bar, submap_options, match_options))
      return true;
  }
  return false;
}

}  // namespace loopstone
