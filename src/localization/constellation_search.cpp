#include "loopstone/localization/constellation_search.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/pose_distance.hpp"

namespace loopstone {
namespace {

constexpr std::size_t kMostPairs = 10'000'000;
constexpr std::int64_t kMostAlignments = 300'000;
constexpr std::size_t kMostRefined = 300;
constexpr double kShortestGapM = 0.3;  ///< nearer ones tell no heading
constexpr double kSigmas = 4.0;        ///< within which distances fit
/// Two alignments so near to one another are of one place.
constexpr double kSameM = 0.2;
constexpr double kSameRad = 0.1;
/// Matches that are this much less probable than the best are of no account.
constexpr double kNegligible = 14.0;
/// Each observation more makes a place so much more probable that these few less decide.
constexpr int kFewerExplained = 1;
/// Of a pose of which nothing is known.
constexpr double kAnywhereM = 1e3;
constexpr double kAnyHeadingRad = 10.0;

/// About how well an observed point and a landmark are known together [m^2].
double variance_of(const LandmarkObservation& observation) {
  return observation.covariance.trace();
}

/// The pose by which two observed points come to lie on the line through two landmarks, their
/// middles on each other.
Pose2 pose_of(const Eigen::Vector2d& seen_a, const Eigen::Vector2d& seen_b,
              const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d seen = seen_b - seen_a;
  const Eigen::Vector2d mapped = b - a;
  const double yaw =
      wrap_angle(std::atan2(mapped.y(), mapped.x()) - std::atan2(seen.y(), seen.x()));
  const Pose2 turn{0.0, 0.0, yaw};
  const Eigen::Vector2d at = 0.5 * (a + b) - turn * Eigen::Vector2d(0.5 * (seen_a + seen_b));
  return {at.x(), at.y(), yaw};
}

PoseWithCovariance2 unknown_about(const Pose2& pose) {
  PoseWithCovariance2 unknown{.pose = pose};
  unknown.covariance.diagonal() << kAnywhereM * kAnywhereM, kAnywhereM * kAnywhereM,
      kAnyHeadingRad * kAnyHeadingRad;
  return unknown;
}

}  // namespace

/// A pose that two pairs give.
struct ConstellationIndex::Alignment {
  Pose2 map_T_robot{};
  std::size_t seen_a = 0;
  std::size_t seen_b = 0;
  std::size_t a = 0;
  std::size_t b = 0;
  int explained = 0;
};

/// One search: alignments, how much they explain, what they are worth.
class ConstellationIndex::Aligner {
 public:
  Aligner(const ConstellationIndex& index, std::span<const LandmarkObservation> observations,
          const ClutterModel& clutter)
      : index_(index), map_(index.map_), observations_(observations), clutter_(clutter) {}

  ConstellationSearch run(std::size_t most) {
    for (const auto& [a, b] : pairs_by_length()) align(a, b);
    keep_one_a_place();
    for (const Alignment& alignment : alignments_) found_.matches.push_back(match_of(alignment));
    keep_best(most);
    return std::move(found_);
  }

 private:
  /// The longest first: they tell the heading best.
  [[nodiscard]] std::vector<std::pair<std::size_t, std::size_t>> pairs_by_length() const {
    std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
    for (std::size_t a = 0; a < observations_.size(); ++a) {
      for (std::size_t b = a + 1; b < observations_.size(); ++b) {
        const double gap = (observations_[a].point - observations_[b].point).norm();
        if (gap >= kShortestGapM) pairs.emplace_back(-gap, a, b);
      }
    }
    std::ranges::sort(pairs);
    std::vector<std::pair<std::size_t, std::size_t>> result;
    for (const auto& [gap, a, b] : pairs) result.emplace_back(a, b);
    return result;
  }

  /// Against all pairs of landmarks that are as far apart.
  void align(std::size_t a, std::size_t b) {
    const LandmarkObservation& seen_a = observations_[a];
    const LandmarkObservation& seen_b = observations_[b];
    const double sigma = map_.largest_sigma_m();
    const double slack =
        kSigmas * std::sqrt(variance_of(seen_a) + variance_of(seen_b) + 2.0 * sigma * sigma) +
        2.0 * map_.largest_radius_m();
    const double gap = (seen_a.point - seen_b.point).norm();
    auto at = std::ranges::lower_bound(index_.gaps_, gap - slack, {}, &Gap::distance_m);
    for (; at != index_.gaps_.end() && at->distance_m <= gap + slack; ++at) {
      try_pair(a, b, at->from, at->to);
      try_pair(a, b, at->to, at->from);
    }
  }

  [[nodiscard]] bool may_be(const LandmarkObservation& observation, std::size_t landmark) const {
    return !observation.id || *observation.id == map_[landmark].id;
  }

  void try_pair(std::size_t seen_a, std::size_t seen_b, std::size_t a, std::size_t b) {
    if (!may_be(observations_[seen_a], a) || !may_be(observations_[seen_b], b)) return;
    if (found_.alignments >= kMostAlignments) {
      found_.complete = false;
      return;
    }
    ++found_.alignments;
    Alignment alignment{pose_of(centre_of(observations_[seen_a], map_[a].radius_m),
                                centre_of(observations_[seen_b], map_[b].radius_m),
                                map_[a].position, map_[b].position),
                        seen_a, seen_b, a, b};
    alignment.explained = explained_from(alignment);
    if (alignment.explained < most_explained_ - kFewerExplained) return;
    most_explained_ = std::max(most_explained_, alignment.explained);
    alignments_.push_back(alignment);
  }

  /// Observations with a landmark where the pose has it, as far as two points tell a pose.
  [[nodiscard]] int explained_from(const Alignment& alignment) const {
    const Eigen::Vector2d& from = observations_[alignment.seen_a].point;
    const Eigen::Vector2d& to = observations_[alignment.seen_b].point;
    const Eigen::Vector2d middle = 0.5 * (from + to);
    const double variance = variance_of(observations_[alignment.seen_a]) +
                            variance_of(observations_[alignment.seen_b]) +
                            2.0 * std::pow(map_.largest_sigma_m(), 2);
    const double heading_variance = variance / (from - to).squaredNorm();
    int explained = 0;
    for (const LandmarkObservation& observation : observations_) {
      const double own = variance_of(observation) + variance +
                         heading_variance * (observation.point - middle).squaredNorm();
      const double reach = kSigmas * std::sqrt(own) + map_.largest_radius_m();
      const Eigen::Vector2d point = alignment.map_T_robot * observation.point;
      if (observation.id) {
        const auto named = map_.index_of(*observation.id);
        explained += named && (map_[*named].position - point).norm() <= reach ? 1 : 0;
      } else {
        explained += map_.within(point, reach).empty() ? 0 : 1;
      }
    }
    return explained;
  }

  void keep_one_a_place() {
    std::erase_if(alignments_, [&](const Alignment& alignment) {
      return alignment.explained < most_explained_ - kFewerExplained;
    });
    std::ranges::stable_sort(alignments_, std::greater{}, &Alignment::explained);
    std::vector<Alignment> kept;
    for (const Alignment& alignment : alignments_) {
      const bool is_known = std::ranges::any_of(kept, [&](const Alignment& other) {
        return is_within(alignment.map_T_robot, other.map_T_robot, kSameM, kSameRad);
      });
      if (is_known) continue;
      if (kept.size() == kMostRefined) {
        found_.complete = false;
        break;
      }
      kept.push_back(alignment);
    }
    alignments_ = std::move(kept);
  }

  [[nodiscard]] ConstellationMatch match_of(const Alignment& alignment) const {
    // By the two pairs alone first, so that the others are looked for where these say.
    LandmarkAssociation association(observations_.size());
    association[alignment.seen_a] = alignment.a;
    association[alignment.seen_b] = alignment.b;
    const PoseWithCovariance2 unknown = unknown_about(alignment.map_T_robot);
    const PoseWithCovariance2 by_two =
        update_by_landmarks(unknown, map_, observations_, association).map_T_robot;
    add_others(by_two, alignment, association);
    const LandmarkPosterior posterior =
        update_by_landmarks(unknown, map_, observations_, association);
    ConstellationMatch match{posterior.map_T_robot, posterior.observations};
    const double clutter =
        static_cast<double>(observations_.size()) - static_cast<double>(posterior.observations);
    // log evidence under the wide normal distribution, with the uniform one in its place.
    const double of_wide =
        -std::log(kAnywhereM * kAnywhereM * kAnyHeadingRad) - 1.5 * std::log(2.0 * kPi);
    const double of_uniform = -std::log(2.0 * kPi * index_.area_m2_);
    match.log_gain = posterior.log_evidence - of_wide + of_uniform +
                     posterior.observations * (clutter_.log_landmark() - clutter_.log_anywhere()) +
                     clutter * (clutter_.log_clutter() - clutter_.log_anywhere());
    return match;
  }

  void add_others(const PoseWithCovariance2& by_two, const Alignment& alignment,
                  LandmarkAssociation& association) const {
    std::vector<LandmarkObservation> others;
    std::vector<std::size_t> numbers;
    for (std::size_t i = 0; i < observations_.size(); ++i) {
      if (i == alignment.seen_a || i == alignment.seen_b) continue;
      others.push_back(observations_[i]);
      numbers.push_back(i);
    }
    const JointAssociation joint = associate_jointly(by_two, map_, others, clutter_);
    for (std::size_t k = 0; k < others.size(); ++k) {
      const auto& landmark = joint.landmarks[k];
      if (landmark && *landmark != alignment.a && *landmark != alignment.b) {
        association[numbers[k]] = landmark;
      }
    }
  }

  void keep_best(std::size_t most) {
    std::ranges::stable_sort(found_.matches, std::greater{}, &ConstellationMatch::log_gain);
    std::vector<ConstellationMatch> kept;
    for (const ConstellationMatch& match : found_.matches) {
      if (kept.size() == most || match.log_gain < found_.matches.front().log_gain - kNegligible) {
        break;
      }
      const bool is_known = std::ranges::any_of(kept, [&](const ConstellationMatch& other) {
        return is_within(match.map_T_robot.pose, other.map_T_robot.pose, kSameM, kSameRad);
      });
      if (!is_known) kept.push_back(match);
    }
    found_.matches = std::move(kept);
  }

  const ConstellationIndex& index_;
  const LandmarkMap& map_;
  std::span<const LandmarkObservation> observations_;
  ClutterModel clutter_;
  std::vector<Alignment> alignments_{};
  int most_explained_ = 2;
  ConstellationSearch found_{};
};

ConstellationIndex::ConstellationIndex(const LandmarkMap& map, double max_range_m) : map_(map) {
  Eigen::Vector2d low = map[0].position;
  Eigen::Vector2d high = low;
  std::size_t pairs = 0;
  for (std::size_t a = 0; a < map.size(); ++a) {
    low = low.cwiseMin(map[a].position);
    high = high.cwiseMax(map[a].position);
    for (const std::size_t b : map.within(map[a].position, 2.0 * max_range_m)) {
      if (b <= a) continue;
      if (++pairs > kMostPairs) {
        throw UsageError(
            "the map has more than 10 million pairs of landmarks that can be seen together; give "
            "the sensor's range (max_range_m), or a part of the map");
      }
      const double distance = (map[a].position - map[b].position).norm();
      if (distance < kShortestGapM) continue;
      gaps_.push_back({distance, static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b)});
    }
  }
  std::ranges::sort(gaps_, {},
                    [](const Gap& gap) { return std::tuple(gap.distance_m, gap.from, gap.to); });
  const Eigen::Vector2d size = high - low + Eigen::Vector2d::Constant(2.0 * max_range_m);
  area_m2_ = size.x() * size.y();
}

ConstellationSearch ConstellationIndex::search(std::span<const LandmarkObservation> observations,
                                               const ClutterModel& clutter,
                                               std::size_t most) const {
  return Aligner(*this, observations, clutter).run(most);
}

}  // namespace loopstone
