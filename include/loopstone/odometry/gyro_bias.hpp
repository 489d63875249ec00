#pragma once

#include "loopstone/base/stamp.hpp"

namespace loopstone {

/// What the bias of a gyro is learned by.
struct GyroBiasNumbers {
  double rate_noise_rad_s = 0.02;
  double wander = 2e-4;
  double largest_rest_rate_rad_s = 0.1;
  double first_sigma_rad_s = 0.02;
};
inline constexpr GyroBiasNumbers kGyroBias{};

template <typename Visitor>
void visit_numbers(const GyroBiasNumbers& n, Visitor&& visit) {
  visit("rate_noise_rad_s", n.rate_noise_rad_s,
        "chosen: of one reading; engines and fans shake the gyro");
  visit("wander", n.wander,
        "chosen: of the bias after a second [rad/s/sqrt(s)], of cheap gyros that warm up");
  visit("largest_rest_rate_rad_s", n.largest_rest_rate_rad_s,
        "chosen: beyond the bias; somebody turns the robot by hand");
  visit("first_sigma_rad_s", n.first_sigma_rad_s,
        "chosen: of the bias of cheap gyros, before any reading");
}

/// The bias of a gyro, learned whenever the robot stands still: a Kalman filter with one state, a
/// slowly wandering constant, and one measurement, the rate that the gyro shows at rest.
class GyroBias {
 public:
  /// A reading of the gyro while the robot stands still. Rates that no bias explains (somebody
  /// turns the robot by hand) are not learned: false.
  bool learn(Stamp stamp, double rate_rad_s);

  /// True when the rate is what this gyro could show at rest.
  [[nodiscard]] bool could_be_rest(double rate_rad_s) const;

  [[nodiscard]] double bias_rad_s() const { return state_.bias_rad_s; }
  [[nodiscard]] double variance() const { return state_.variance; }

  /// What was learned.
  struct State {
    double bias_rad_s = 0.0;
    double variance = kGyroBias.first_sigma_rad_s * kGyroBias.first_sigma_rad_s;  ///< [rad^2/s^2]
    Stamp learned{};                                                              ///< last
    bool has_learned = false;

    template <typename Archive>
    void archive(Archive& a) {
      a(bias_rad_s, variance, learned, has_learned);
    }
  };

  [[nodiscard]] const State& state() const { return state_; }
  /// Throws UsageError when it can't have been learned.
  void restore(const State& state);

 private:
  State state_{};
};

}  // namespace loopstone
