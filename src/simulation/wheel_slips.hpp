#pragma once

#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/realism.hpp"

namespace loopstone {

/// Wheels that spin now and then: they turn, and the robot does not move with them.
class WheelSlips {
 public:
  WheelSlips() = default;
  WheelSlips(const RealismWheels& options, Rng rng);

  struct Slip {
    double ahead_m = 0.0;
    double turned_rad = 0.0;
  };
  /// What the wheels turned for nothing since the last call, by the way that the robot went.
  [[nodiscard]] Slip since(double time_s, double travelled_m);

 private:
  RealismWheels options_{};
  Rng rng_{0};
  double next_at_m_ = 0.0;
  double last_s_ = 0.0;
  Slip whole_{};
  double left_s_ = 0.0;  ///< of the slip under way
};

}  // namespace loopstone
