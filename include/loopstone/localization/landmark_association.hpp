#pragma once

#include <span>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/localization/landmark_map.hpp"
#include "loopstone/localization/landmark_update.hpp"
#include "loopstone/sensor/landmark_reading.hpp"

namespace loopstone {

/// What observations are worth that are of no landmark.
struct ClutterModel {
  double share = 0.05;        ///< of the observations, [0, 1]
  double max_range_m = 30.0;  ///< clutter lies anywhere within
  double gate_chi2 = 13.8;  ///< farther from a landmark an observation is not of it; 99.9 % of two

  /// log p of an observation that is of a landmark, before its own density.
  [[nodiscard]] double log_landmark() const;
  /// log p of one that is not, the share included.
  [[nodiscard]] double log_clutter() const;
  /// The same were the robot anywhere: nothing is known of where a landmark is to be seen.
  [[nodiscard]] double log_anywhere() const;
};

/// The most probable set of pairs of observations and landmarks, all of them judged together.
struct JointAssociation {
  LandmarkAssociation landmarks{};
  double log_probability = 0.0;  ///< of the observations, clutter included
  bool complete = true;          ///< false: the search was cut short, a better set may exist
};

/// Pairs the observations of a reading with landmarks: each landmark at most once, each pair within
/// its gate given those before it. Observations share the error of the pose, so that a set is
/// judged by the joint density of its innovations, N(v; 0, H P H^T + R), and those left over by
/// that of clutter: branch and bound over the pairings, each followed by the pose that it implies
/// (to first order where the prior is within 0.2 m and 0.03 rad, else from the prior anew). An
/// observation with an id is of that landmark or of none.
///
/// \param most_nodes  bounds the work
/// Cost: about O(observations) while the prior is narrower than the gaps between landmarks.
/// Source: Neira and Tardos 2001, "Data association in stochastic mapping using the joint
/// compatibility test"; judged by probability as in Cox and Hingorani 1996.
[[nodiscard]] JointAssociation associate_jointly(const PoseWithCovariance2& prior,
                                                 const LandmarkMap& map,
                                                 std::span<const LandmarkObservation> observations,
                                                 const ClutterModel& clutter,
                                                 int most_nodes = 20000);

}  // namespace loopstone
