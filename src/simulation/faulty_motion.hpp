#pragma once

#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/drive.hpp"
#include "loopstone/simulation/simulated_faults.hpp"

namespace loopstone {

/// What odometry with a fault takes the robot's motion for. Without a fault: the motion.
class FaultyMotion {
 public:
  FaultyMotion(const Drive& drive, const SimulatedFaults& faults, Rng rng);

  struct Motion {
    double travelled_m = 0.0;
    double turned_rad = 0.0;
  };
  /// The motion since the last call as the wheels see it, before their own errors. Times grow from
  /// call to call.
  [[nodiscard]] Motion until(double time_s);

  /// The mean rate of turning around a time as a gyro sees it, before its own errors [rad/s].
  [[nodiscard]] double yaw_rate(double time_s, double span_s) const;

  /// Whether wheels are read at all.
  [[nodiscard]] bool is_read(double time_s) const;

 private:
  [[nodiscard]] bool acts(double time_s) const;

  const Drive& drive_;
  SimulatedFaults faults_;
  double strength_;
  Rng rng_;
  double seen_until_s_ = 0.0;
  double next_jump_s_ = 0.0;
};

}  // namespace loopstone
