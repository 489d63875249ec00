#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "localization/landmark_tracks.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/sensor/landmark_reading.hpp"

namespace loopstone {

/// Sightings that are taken to be of one landmark.
struct LandmarkGroup {
  std::optional<int> name{};
  std::vector<std::size_t> tracks{};  ///< in the order of their first sightings
  double radius_m = 0.0;
};

/// A point and how well it is known.
struct UncertainPoint {
  Eigen::Vector2d position{0.0, 0.0};
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
};

/// What was seen, and from where.
struct LandmarkScene {
  std::span<const std::vector<LandmarkObservation>> seen;
  std::span<const LandmarkTrack> tracks;

  [[nodiscard]] const LandmarkObservation& of(const Sighting& sighting) const {
    return seen[sighting.node][sighting.observation];
  }
};

/// All sightings of a group in the order of their tracks.
[[nodiscard]] std::vector<Sighting> sightings_of(const LandmarkGroup& group,
                                                 const LandmarkScene& scene);

/// Where sightings put a landmark of that radius if the poses are right: the weighted mean of all,
/// map frame.
[[nodiscard]] UncertainPoint place_of(std::span<const Sighting> sightings, double radius_m,
                                      const LandmarkScene& scene,
                                      std::span<const Pose2> map_T_node);

/// The largest distance between the places that a landmark was seen from; of the first to any.
[[nodiscard]] double baseline_m(std::span<const Sighting> sightings,
                                std::span<const Pose2> map_T_node);

/// The radius that explains best where a landmark's surface was met, from several sides; 0 where
/// that explains no more than a flat one would. By trying each from 0 to the largest.
/// Cost: O(sightings x radii).
[[nodiscard]] double radius_of(std::span<const Sighting> sightings, double radius_max_m,
                               const LandmarkScene& scene, std::span<const Pose2> map_T_node);

}  // namespace loopstone
