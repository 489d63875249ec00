#pragma once

#include <array>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/simulation/realism.hpp"

namespace loopstone {

/// How a robot leans.
struct FloorTilt {
  double nose_up_rad = 0.0;
  double left_up_rad = 0.0;
};

/// A floor that is not level: waves, sills across the ways, ramps. The same place leans the robot
/// the same way at every visit; the way on which it stands there counts too.
class UnevenFloor {
 public:
  UnevenFloor(const RealismUneven& options, Rng rng);

  /// Of a robot that stands on it with all wheels.
  [[nodiscard]] FloorTilt tilt_at(const Pose2& map_T_robot) const;
  /// Height of the floor [m].
  [[nodiscard]] double height_m(const Eigen::Vector2d& point) const;
  /// The range of a beam that leaves `height_m` above the floor in `bearing_rad` from the robot's x
  /// axis and would meet a wall at `level_range_m` were the robot level: along the inclined beam,
  /// or to the floor or the ceiling when that is nearer.
  [[nodiscard]] double range_m(double level_range_m, double bearing_rad, double height_m,
                               const FloorTilt& tilt) const;

 private:
  struct Wave {
    Eigen::Vector2d number{0.0, 0.0};  ///< [rad/m]
    double height_m = 0.0;
    double phase_rad = 0.0;
  };
  RealismUneven options_;
  std::array<Wave, 5> waves_{};
  Eigen::Vector2d sill_phase_m_;
  Eigen::Vector2d ramp_phase_m_;
};

}  // namespace loopstone
