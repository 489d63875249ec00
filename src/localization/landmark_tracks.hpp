#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/sensor/landmark_reading.hpp"

namespace loopstone {

/// One of the things seen from a node.
struct Sighting {
  std::size_t node = 0;
  std::size_t observation = 0;
};

/// A thing that was followed while it was in view.
struct LandmarkTrack {
  std::optional<int> name{};
  std::vector<Sighting> sightings{};  ///< by node; at most one each
};

/// Follows what is seen from node to node. Where things are is known from the robot and not on a
/// map, so drift does not matter; from one node to the next the robot's motion is an unknown that
/// all of them share, and they are paired jointly (landmark_association.hpp). What was not seen for
/// some metres is forgotten; when it comes back it is another track.
///
/// \param motions  to each node from the one before; the first is not used
/// \param seen     from each node
/// \return in the order of their first sightings, each observation in one of them
/// Cost: O(observations log observations).
[[nodiscard]] std::vector<LandmarkTrack> follow_landmarks(
    std::span<const PoseWithCovariance2> motions,
    std::span<const std::vector<LandmarkObservation>> seen, double clutter_share);

}  // namespace loopstone
