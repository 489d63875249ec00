#include "simulation/wheel_slips.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {

namespace {

constexpr double kSlipS = 0.5;  ///< that a slip takes

}  // namespace

WheelSlips::WheelSlips(const RealismWheels& options, Rng rng) : options_(options), rng_(rng) {
  next_at_m_ = options.slip_every_m * rng_.uniform(0.3, 1.5);
}

WheelSlips::Slip WheelSlips::since(double time_s, double travelled_m) {
  if (!options_.on) return {};
  const double span = time_s - last_s_;
  last_s_ = time_s;
  if (std::abs(travelled_m) >= next_at_m_) {
    whole_ = {rng_.uniform(0.2, 1.0) * options_.slip_m,
              rng_.uniform(-1.0, 1.0) * options_.slip_rad};
    next_at_m_ = std::abs(travelled_m) + options_.slip_every_m * rng_.uniform(0.5, 1.5);
    left_s_ = kSlipS;
  }
  const double share = std::min(span, left_s_) / kSlipS;
  left_s_ -= std::min(span, left_s_);
  return {share * whole_.ahead_m, share * whole_.turned_rad};
}

}  // namespace loopstone
