#include "loopstone/odometry/gyro_bias.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {

namespace {

constexpr double kRateNoise = 0.02;       // of one reading [rad/s]; engines and fans shake the gyro
constexpr double kBiasWander = 2e-4;      // of the bias after 1 s [rad/s/sqrt(s)]
constexpr double kLargestRestRate = 0.1;  // beyond the bias: somebody turns the robot [rad/s]

}  // namespace

bool GyroBias::could_be_rest(double rate_rad_s) const {
  return std::abs(rate_rad_s - bias_rad_s_) < kLargestRestRate;
}

bool GyroBias::learn(Stamp stamp, double rate_rad_s) {
  if (!could_be_rest(rate_rad_s)) return false;
  if (has_learned_) {
    variance_ += kBiasWander * kBiasWander * std::max(0.0, (stamp - learned_).seconds());
  }
  const double gain = variance_ / (variance_ + kRateNoise * kRateNoise);
  bias_rad_s_ += gain * (rate_rad_s - bias_rad_s_);
  variance_ *= 1.0 - gain;
  learned_ = stamp;
  has_learned_ = true;
  return true;
}

}  // namespace loopstone
