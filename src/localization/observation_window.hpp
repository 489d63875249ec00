#pragma once

#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/sensor/landmark_reading.hpp"

namespace loopstone {

/// What was seen lately, where it is from the robot now. A constellation is often more than a
/// single reading shows: a sensor that tells one landmark at a time, reflectors behind the robot.
class ObservationWindow {
 public:
  /// The robot moved, from_T_to: what was seen goes on being where it is, a little less certain.
  void move(const PoseWithCovariance2& motion);
  /// Takes in a reading, in place of what it shows again.
  void add(const std::vector<LandmarkObservation>& observations);

  [[nodiscard]] const std::vector<LandmarkObservation>& observations() const {
    return observations_;
  }

 private:
  std::vector<LandmarkObservation> observations_{};  ///< the newest last
};

}  // namespace loopstone
