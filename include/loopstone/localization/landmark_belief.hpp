#pragma once

#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/localization/constellation_search.hpp"
#include "loopstone/localization/landmark_association.hpp"
#include "loopstone/localization/landmark_map.hpp"
#include "loopstone/sensor/landmark_reading.hpp"

namespace loopstone {

/// A place where the robot may be.
struct LandmarkPlace {
  PoseWithCovariance2 map_T_robot{};
  double weight = 0.0;  ///< [0, 1], belief in it
  int id = 0;           ///< the same as long as it is followed
  // Of the last reading that it was held against.
  int explained = 0;  ///< observations that are of a landmark
  double chi2 = 0.0;  ///< of them, see LandmarkPosterior
};

/// What can be said of an observation without knowing where the robot is.
struct BlindExpectation {
  double log_density = 0.0;  ///< [log 1/m^2]
  /// It is of something that was seen before. Then it tells little anew: a landmark that a place
  /// explained is explained again, and what it did not explain stays unexplained.
  bool is_seen_before = false;
};

/// What is believed of the robot's place: a few places, each a normal distribution, and the rest:
/// that it is somewhere else. Every reading is more or less probable under each of them (Bayes); of
/// the rest nothing predicts where landmarks are to be seen. So a robot that was carried away is
/// told by readings that no place explains, and one on a map with places that look alike stays in
/// several of them until they differ.
///
/// All is computed, nothing drawn: the same readings give the same belief.
/// Source: multiple hypothesis localisation, Jensfelt and Kristensen 2001, "Active global
/// localization for a mobile robot using multiple hypothesis tracking"; mixture of normal
/// distributions, Alspach and Sorenson 1972.
class LandmarkBelief {
 public:
  /// \param map  must outlive the belief
  LandmarkBelief(const LandmarkMap& map, const ClutterModel& clutter)
      : map_(map), clutter_(clutter) {}

  /// The robot is about there, as far as whoever says so is right.
  void start_at(const PoseWithCovariance2& map_T_robot);
  /// The robot moved, from_T_to.
  void predict(const PoseWithCovariance2& motion);
  /// It saw something. Without observations nothing changes.
  /// \param expected  of each observation
  void update(std::span<const LandmarkObservation> observations,
              std::span<const BlindExpectation> expected);
  /// The same where nothing was seen before.
  void update(std::span<const LandmarkObservation> observations);
  /// Places that a search of the map found take their part of the rest's weight; one that is known
  /// has it at least.
  /// \return how many are new
  int add(std::span<const ConstellationMatch> matches);

  /// The most probable first; none at the beginning.
  [[nodiscard]] const std::vector<LandmarkPlace>& places() const { return places_; }
  /// Belief that the robot is at none of them.
  [[nodiscard]] double rest() const { return rest_; }
  /// Belief within so much of a pose.
  [[nodiscard]] double mass_near(const Pose2& map_T_robot, double metres, double radians) const;

 private:
  void settle();
  /// log p of those that no landmark explains.
  [[nodiscard]] double log_unexplained(const LandmarkAssociation& landmarks,
                                       std::span<const BlindExpectation> expected) const;

  const LandmarkMap& map_;
  ClutterModel clutter_;
  std::vector<LandmarkPlace> places_{};
  double rest_ = 1.0;
  int next_id_ = 0;
};

}  // namespace loopstone
