#pragma once

#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/localization/landmark_belief.hpp"
#include "loopstone/sensor/landmark_reading.hpp"

namespace loopstone {

/// What was seen lately, where it is from the robot now. A constellation is often more than a
/// single reading shows: a sensor that tells one landmark at a time, reflectors behind the robot.
class ObservationWindow {
 public:
  /// The robot moved, from_T_to: what was seen goes on being where it is, a little less certain.
  void move(const PoseWithCovariance2& motion);
  /// The robot is not where it was believed to be: what was seen before may be elsewhere.
  void clear() { observations_.clear(); }
  /// Takes in a reading, in place of what it shows again.
  void add(const std::vector<LandmarkObservation>& observations);

  /// What can be said of a reading by what was seen before, wherever the robot is: a static thing
  /// is seen again where it was.
  /// \param log_anywhere  log density of what was not seen before
  [[nodiscard]] std::vector<BlindExpectation> expectations(
      const std::vector<LandmarkObservation>& reading, double log_anywhere) const;

  [[nodiscard]] const std::vector<LandmarkObservation>& observations() const {
    return observations_;
  }

 private:
  std::vector<LandmarkObservation> observations_{};  ///< the newest last
};

}  // namespace loopstone
