#include "loopstone/odometry/gyro_bias.hpp"

#include <algorithm>
#include <cmath>

#include "loopstone/base/sound_state.hpp"

namespace loopstone {

bool GyroBias::could_be_rest(double rate_rad_s) const {
  return std::abs(rate_rad_s - state_.bias_rad_s) < kGyroBias.largest_rest_rate_rad_s;
}

bool GyroBias::learn(Stamp stamp, double rate_rad_s) {
  if (!could_be_rest(rate_rad_s)) return false;
  if (state_.has_learned) {
    state_.variance +=
        kGyroBias.wander * kGyroBias.wander * std::max(0.0, (stamp - state_.learned).seconds());
  }
  const double gain =
      state_.variance / (state_.variance + kGyroBias.rate_noise_rad_s * kGyroBias.rate_noise_rad_s);
  state_.bias_rad_s += gain * (rate_rad_s - state_.bias_rad_s);
  state_.variance *= 1.0 - gain;
  state_.learned = stamp;
  state_.has_learned = true;
  return true;
}

void GyroBias::restore(const State& state) {
  require_sound(std::isfinite(state.bias_rad_s) && is_amount(state.variance),
                "a gyro's bias that is no number");
  state_ = state;
}

}  // namespace loopstone
