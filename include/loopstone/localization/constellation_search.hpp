#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/localization/landmark_association.hpp"
#include "loopstone/localization/landmark_map.hpp"
#include "loopstone/sensor/landmark_reading.hpp"

namespace loopstone {

/// A place from which what was seen is to be seen.
struct ConstellationMatch {
  PoseWithCovariance2 map_T_robot{};
  int explained = 0;  ///< observations that are of a landmark
  /// log of how much more probable this place, with a small volume of poses about it, makes the
  /// observations than not knowing where the robot is does. Above 0 it has gained belief.
  double log_gain = 0.0;
};

/// What a search of the whole map found.
struct ConstellationSearch {
  std::vector<ConstellationMatch> matches{};  ///< the best first
  std::int64_t alignments = 0;                ///< pairs of pairs that were tried
  bool complete = true;                       ///< false: there were too many to try all
};

/// Landmarks by how far they lie from one another.
///
/// Two observations and two landmarks as far apart as they are give a pose; what else was seen
/// confirms it or does not. All pairs of observations are tried against all pairs of landmarks that
/// fit, so that no clutter hides a place that two observations show. Every pose that explains about
/// as many observations as the best is refined (update_by_landmarks) and weighed: a uniform
/// distribution over the landmarks' surroundings comes before the observations.
///
/// Source: pairwise distances as the invariants of a constellation, Grimson and Lozano-Perez 1987,
/// "Localizing overlapping parts by searching the interpretation tree"; weights by Laplace's
/// approximation, MacKay 2003, chapter 27.
class ConstellationIndex {
 public:
  /// \param max_range_m  of the sensor: landmarks farther apart than twice that are never seen
  ///                     together
  /// Memory: 16 bytes a pair. Throws UsageError for more than 10 million pairs.
  ConstellationIndex(const LandmarkMap& map, double max_range_m);

  /// At most `most` places whose belief is not negligible beside the best one's. The same for any
  /// number of threads: it uses one. Needs two observations; one alone tells no pose.
  /// Cost: O(pairs of observations x pairs of landmarks that fit), at most 300,000 alignments, each
  /// about 1 us an observation.
  [[nodiscard]] ConstellationSearch search(std::span<const LandmarkObservation> observations,
                                           const ClutterModel& clutter,
                                           std::size_t most = 30) const;

  /// Where a robot can be that sees any of the landmarks: the area about them [m^2].
  [[nodiscard]] double area_m2() const { return area_m2_; }

 private:
  struct Gap {
    double distance_m = 0.0;
    std::uint32_t from = 0;
    std::uint32_t to = 0;
  };
  struct Alignment;
  class Aligner;

  const LandmarkMap& map_;
  std::vector<Gap> gaps_{};  ///< by distance
  double area_m2_ = 0.0;
};

}  // namespace loopstone
