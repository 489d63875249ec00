#pragma once

#include "loopstone/base/stamp.hpp"

namespace loopstone {

/// The bias of a gyro, learned whenever the robot stands still: a Kalman filter with one state, a
/// slowly wandering constant, and one measurement, the rate that the gyro shows at rest.
class GyroBias {
 public:
  /// A reading of the gyro while the robot stands still. Rates that no bias explains (somebody
  /// turns the robot by hand) are not learned: false.
  bool learn(Stamp stamp, double rate_rad_s);

  /// True when the rate is what this gyro could show at rest.
  [[nodiscard]] bool could_be_rest(double rate_rad_s) const;

  [[nodiscard]] double bias_rad_s() const { return bias_rad_s_; }
  [[nodiscard]] double variance() const { return variance_; }

  template <typename Archive>
  void archive(Archive& a) {
    a(bias_rad_s_, variance_, learned_, has_learned_);
  }

 private:
  double bias_rad_s_ = 0.0;
  double variance_ = 0.02 * 0.02;  ///< [rad^2/s^2]; the bias of cheap gyros, before any reading
  Stamp learned_{};
  bool has_learned_ = false;
};

}  // namespace loopstone
