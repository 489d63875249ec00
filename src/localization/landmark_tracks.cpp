#include "localization/landmark_tracks.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "localization/landmark_group.hpp"
#include "localization/landmark_mapping_numbers.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/localization/landmark_association.hpp"
#include "loopstone/localization/landmark_map.hpp"
#include "loopstone/localization/landmark_update.hpp"

namespace loopstone {
namespace {

/// What is in view, or was until a moment ago; robot frame.
struct Followed {
  std::size_t track = 0;
  int id = 0;  ///< its name, or a number below zero
  Eigen::Vector2d position{0.0, 0.0};
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  double unseen_m = 0.0;

  [[nodiscard]] double sigma_m() const { return largest_sigma(covariance); }
};

class Follower {
 public:
  explicit Follower(double clutter_share)
      : clutter_{.share = clutter_share, .gate_chi2 = kLandmarkMapping.gate_chi2} {}

  void step(const PoseWithCovariance2& motion, std::size_t node,
            std::span<const LandmarkObservation> seen) {
    const LandmarkAssociation pairs = move(motion, seen);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (pairs[i]) {
        take_in(seen[i], followed_[*pairs[i]], {node, i});
      } else {
        begin(seen[i], {node, i});
      }
    }
    std::erase_if(followed_, [](const Followed& thing) {
      return thing.unseen_m > kLandmarkMapping.forget_m ||
             thing.sigma_m() > kLandmarkMapping.forget_sigma_m;
    });
  }

  [[nodiscard]] std::vector<LandmarkTrack> take() { return std::move(tracks_); }

 private:
  /// Which of those followed each one seen is, and all of them as seen from here.
  LandmarkAssociation move(const PoseWithCovariance2& motion,
                           std::span<const LandmarkObservation> seen) {
    LandmarkAssociation pairs(seen.size());
    if (followed_.empty()) return pairs;
    PoseWithCovariance2 moved = motion;
    if (!seen.empty()) {
      const LandmarkMap map(as_map());
      pairs = associate_jointly(motion, map, seen, clutter_).landmarks;
      moved = update_by_landmarks(motion, map, seen, pairs).map_T_robot;
    }
    const double way_m = motion.pose.translation().norm();
    const double stray_m = way_m > 0.0 ? kLandmarkMapping.stray_m : 0.0;
    for (Followed& thing : followed_) {
      const LandmarkJacobians j = landmark_jacobians(moved.pose, thing.position);
      thing.position = moved.pose.inverse() * thing.position;
      thing.covariance = j.landmark * thing.covariance * j.landmark.transpose() +
                         j.from * moved.covariance * j.from.transpose() +
                         stray_m * stray_m * Eigen::Matrix2d::Identity();
      thing.unseen_m += way_m;
    }
    return pairs;
  }

  [[nodiscard]] std::vector<MappedLandmark> as_map() const {
    std::vector<MappedLandmark> map;
    for (const Followed& thing : followed_) {
      map.push_back({.id = thing.id,
                     .position = thing.position,
                     .sigma_m = std::max(thing.sigma_m(), kLandmarkMapping.least_sigma_m)});
    }
    return map;
  }

  /// Kalman's filter.
  void take_in(const LandmarkObservation& seen, Followed& thing, const Sighting& sighting) {
    const Eigen::Matrix2d gain = thing.covariance * (thing.covariance + seen.covariance).inverse();
    thing.position += gain * (seen.point - thing.position);
    const Eigen::Matrix2d covariance = (Eigen::Matrix2d::Identity() - gain) * thing.covariance;
    thing.covariance = 0.5 * (covariance + covariance.transpose());
    thing.unseen_m = 0.0;
    tracks_[thing.track].sightings.push_back(sighting);
  }

  void begin(const LandmarkObservation& seen, const Sighting& sighting) {
    const int id = seen.id.value_or(-1 - static_cast<int>(tracks_.size()));
    // Where it is told to be by name, it isn't any more.
    std::erase_if(followed_, [&](const Followed& thing) { return thing.id == id; });
    followed_.push_back(
        {.track = tracks_.size(), .id = id, .position = seen.point, .covariance = seen.covariance});
    tracks_.push_back({seen.id, {sighting}});
  }

  ClutterModel clutter_;
  std::vector<Followed> followed_{};
  std::vector<LandmarkTrack> tracks_{};
};

}  // namespace

std::vector<LandmarkTrack> follow_landmarks(std::span<const PoseWithCovariance2> motions,
                                            std::span<const std::vector<LandmarkObservation>> seen,
                                            double clutter_share) {
  Follower follower(clutter_share);
  for (std::size_t node = 0; node < seen.size(); ++node) {
    const PoseWithCovariance2 motion = node == 0 ? PoseWithCovariance2{} : motions[node];
    follower.step(motion, node, seen[node]);
  }
  return follower.take();
}

}  // namespace loopstone
