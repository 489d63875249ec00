#include "localization/landmark_recognition.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "localization/landmark_mapping_numbers.hpp"
#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "loopstone/geometry/rigid_motion.hpp"
#include "loopstone/graph/marginals.hpp"
#include "loopstone/localization/landmark_association.hpp"
#include "loopstone/localization/landmark_map.hpp"

namespace loopstone {
namespace {

/// Where a group is by its own sightings, and the node in their midst.
struct Placed {
  std::size_t group = 0;
  UncertainPoint on_map{};
  NodeId anchor{};
};

class Recognition {
 public:
  Recognition(const PoseGraph& graph, std::span<const LandmarkGroup> groups,
              const LandmarkScene& scene)
      : graph_(graph), groups_(groups), scene_(scene) {}

  std::vector<GroupPair> run(std::span<const std::size_t> newer,
                             std::span<const std::size_t> older) {
    newer_ = placed(newer);
    std::vector<Placed> all = placed(older);
    if (newer_.empty() || all.empty()) return {};
    here_ = newer_[newer_.size() / 2].anchor;
    // The pose is told against the nearest of them.
    const auto nearest = std::ranges::min_element(
        all, {}, [&](const Placed& old) { return distance_to_newer(old.on_map.position); });
    there_ = nearest->anchor;
    const PairMarginals joint = joint_covariances(graph_, std::vector{std::pair{there_, here_}});
    if (!joint.available) return {};
    set_prior(joint.covariances.front());
    for (const Placed& old : all) {
      if (distance_to_newer(old.on_map.position) < reach_m()) older_.push_back(old);
    }
    if (older_.empty()) return {};
    find_own_spreads();
    return judged_pairs();
  }

 private:
  [[nodiscard]] const Pose2& pose(NodeId node) const {
    return graph_.poses[static_cast<std::size_t>(node.index)];
  }

  [[nodiscard]] std::vector<Placed> placed(std::span<const std::size_t> indices) const {
    std::vector<Placed> result;
    for (const std::size_t index : indices) {
      const LandmarkGroup& group = groups_[index];
      const std::vector<Sighting> sightings = sightings_of(group, scene_);
      const auto& last = scene_.tracks[group.tracks.back()].sightings;
      result.push_back({index, place_of(sightings, group.radius_m, scene_, graph_.poses),
                        NodeId{static_cast<int>(last[last.size() / 2].node)}});
    }
    return result;
  }

  [[nodiscard]] double distance_to_newer(const Eigen::Vector2d& point) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Placed& thing : newer_)
      least = std::min(least, (thing.on_map.position - point).norm());
    return least;
  }

  void set_prior(const Eigen::Matrix<double, 6, 6>& joint) {
    const Eigen::Matrix3d between = relative_covariance(pose(there_), pose(here_), joint);
    prior_ = {pose(here_), rotated(between, pose(there_).rotation())};
    prior_.covariance.diagonal().array() += kLeastVariance;
  }

  /// What the gate leaves in reach of where something is expected.
  [[nodiscard]] double reach_m() const {
    double arm_m = 0.0;
    for (const Placed& thing : newer_) {
      arm_m = std::max(arm_m, (thing.on_map.position - prior_.pose.translation()).norm());
    }
    const double sigma_m = largest_sigma(prior_.covariance.topLeftCorner<2, 2>()) +
                           arm_m * std::sqrt(prior_.covariance(2, 2));
    return kNearM + std::sqrt(2.0 * kLandmarkMapping.gate_chi2) * sigma_m;
  }

  /// Of each thing beside its own sightings: the poses between it and here, or there.
  void find_own_spreads() {
    std::vector<std::pair<NodeId, NodeId>> pairs;
    for (const Placed& thing : newer_) pairs.emplace_back(here_, thing.anchor);
    for (const Placed& thing : older_) pairs.emplace_back(there_, thing.anchor);
    const PairMarginals joint = joint_covariances(graph_, pairs);
    std::size_t next = 0;
    for (Placed& thing : newer_) widen(thing, here_, joint.covariances[next++]);
    for (Placed& thing : older_) widen(thing, there_, joint.covariances[next++]);
  }

  void widen(Placed& thing, NodeId from, const Eigen::Matrix<double, 6, 6>& joint) const {
    if (thing.anchor == from) return;
    const Eigen::Matrix3d between =
        rotated(relative_covariance(pose(from), pose(thing.anchor), joint), pose(from).rotation());
    const Eigen::Vector2d arm = thing.on_map.position - pose(thing.anchor).translation();
    const Eigen::Matrix<double, 2, 3> swung = RigidMotion<2>::point_jacobian(arm);
    thing.on_map.covariance += swung * between * swung.transpose();
  }

  [[nodiscard]] std::vector<LandmarkObservation> as_observations() const {
    std::vector<LandmarkObservation> seen;
    const Pose2 here_T_map = prior_.pose.inverse();
    const Eigen::Matrix2d turn = here_T_map.rotation();
    for (const Placed& thing : newer_) {
      seen.push_back({.point = here_T_map * thing.on_map.position,
                      .covariance = turn * thing.on_map.covariance * turn.transpose()});
    }
    return seen;
  }

  [[nodiscard]] LandmarkMap map_without(std::optional<std::size_t> left_out) const {
    std::vector<MappedLandmark> map;
    for (std::size_t i = 0; i < older_.size(); ++i) {
      if (i == left_out) continue;
      const UncertainPoint& point = older_[i].on_map;
      const double sigma_m =
          std::max(largest_sigma(point.covariance), kLandmarkMapping.least_sigma_m);
      map.push_back({.id = static_cast<int>(i), .position = point.position, .sigma_m = sigma_m});
    }
    return LandmarkMap(std::move(map));
  }

  /// A new landmark may be anywhere where landmarks stand: as densely as they do here.
  [[nodiscard]] ClutterModel new_ones() const {
    const double reach_m = kLandmarkMapping.density_reach_m;
    const Eigen::Vector2d centre = newer_[newer_.size() / 2].on_map.position;
    const auto near = std::ranges::count_if(older_, [&](const Placed& thing) {
      return (thing.on_map.position - centre).norm() < reach_m;
    });
    return {
        .share = 0.5,
        .max_range_m = reach_m / std::sqrt(static_cast<double>(std::max<std::int64_t>(near, 1))),
        .gate_chi2 = kLandmarkMapping.gate_chi2};
  }

  /// Log of how probable the best pairing is where one landmark is taken away.
  [[nodiscard]] double log_without(std::size_t landmark, std::span<const LandmarkObservation> seen,
                                   const ClutterModel& clutter) const {
    if (older_.size() == 1) return static_cast<double>(seen.size()) * clutter.log_clutter();
    return associate_jointly(prior_, map_without(landmark), seen, clutter,
                             kLandmarkMapping.most_nodes)
        .log_probability;
  }

  [[nodiscard]] std::vector<GroupPair> judged_pairs() const {
    const std::vector<LandmarkObservation> seen = as_observations();
    const ClutterModel clutter = new_ones();
    const JointAssociation best =
        associate_jointly(prior_, map_without({}), seen, clutter, kLandmarkMapping.most_nodes);
    std::vector<GroupPair> pairs;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (!best.landmarks[i]) continue;
      const std::size_t k = *best.landmarks[i];
      const Placed& old = older_[k];
      const double gain = best.log_probability - log_without(k, seen, clutter);
      if (were_seen_together(newer_[i].group, old.group)) continue;
      if (!best.complete || gain < std::log(kLandmarkMapping.odds)) continue;
      pairs.push_back({newer_[i].group, old.group, moves_map(newer_[i], old)});
    }
    return pairs;
  }

  /// More often than clutter has it that strays into one of them.
  [[nodiscard]] bool were_seen_together(std::size_t a, std::size_t b) const {
    std::vector<std::size_t> nodes;
    for (const Sighting& sighting : sightings_of(groups_[a], scene_))
      nodes.push_back(sighting.node);
    std::ranges::sort(nodes);
    const std::vector<Sighting> others = sightings_of(groups_[b], scene_);
    const auto together = std::ranges::count_if(others, [&](const Sighting& sighting) {
      return std::ranges::binary_search(nodes, sighting.node);
    });
    const auto fewer = static_cast<double>(std::min(nodes.size(), others.size()));
    return static_cast<double>(together) > kLandmarkMapping.together_share * fewer;
  }

  [[nodiscard]] bool moves_map(const Placed& newer, const Placed& older) const {
    const double sigma_m = hypotenuse(own_sigma(newer.group), own_sigma(older.group));
    return (newer.on_map.position - older.on_map.position).norm() >
           kLandmarkMapping.resolve_sigmas * sigma_m;
  }

  [[nodiscard]] double own_sigma(std::size_t group) const {
    const LandmarkGroup& g = groups_[group];
    return largest_sigma(
        place_of(sightings_of(g, scene_), g.radius_m, scene_, graph_.poses).covariance);
  }

  static constexpr double kLeastVariance = 1e-8;
  static constexpr double kNearM = 0.5;

  const PoseGraph& graph_;
  std::span<const LandmarkGroup> groups_;
  const LandmarkScene& scene_;
  std::vector<Placed> newer_{};
  std::vector<Placed> older_{};  ///< in reach
  NodeId here_{};
  NodeId there_{};
  PoseWithCovariance2 prior_{};
};

}  // namespace

std::vector<GroupPair> recognise(const PoseGraph& graph, std::span<const LandmarkGroup> groups,
                                 std::span<const std::size_t> newer,
                                 std::span<const std::size_t> older, const LandmarkScene& scene) {
  return Recognition(graph, groups, scene).run(newer, older);
}

}  // namespace loopstone
