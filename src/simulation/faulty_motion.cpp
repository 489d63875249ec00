#include "simulation/faulty_motion.hpp"

#include <algorithm>

namespace loopstone {

namespace {

using Fault = SimulatedOdometryFault;

constexpr double kUsualFactor = 1.6;
constexpr double kUsualLagS = 0.4;
constexpr double kUsualJump = 1.0;
/// Between jumps, from half to one and a half of it.
constexpr double kJumpEveryS = 10.0;

double strength_of(const SimulatedFaults& faults) {
  if (faults.strength > 0.0) return faults.strength;
  if (faults.odometry == Fault::kScaled) return kUsualFactor;
  return faults.odometry == Fault::kLagging ? kUsualLagS : kUsualJump;
}

}  // namespace

FaultyMotion::FaultyMotion(const Drive& drive, const SimulatedFaults& faults, Rng rng)
    : drive_(drive),
      faults_(faults),
      strength_(strength_of(faults)),
      rng_(rng),
      next_jump_s_(faults.from_s + kJumpEveryS * rng_.uniform(0.5, 1.5)) {}

bool FaultyMotion::acts(double time_s) const {
  return faults_.odometry != Fault::kNone && time_s >= faults_.from_s &&
         (faults_.to_s <= 0.0 || time_s < faults_.to_s);
}

bool FaultyMotion::is_read(double time_s) const {
  return faults_.odometry != Fault::kMissing || !acts(time_s);
}

FaultyMotion::Motion FaultyMotion::until(double time_s) {
  double to = time_s;
  // Time does not run backwards when the lag sets in: until then the wheels seem to stand.
  if (acts(time_s) && faults_.odometry == Fault::kLagging)
    to = std::max(seen_until_s_, time_s - strength_);
  // Wheels stand while hands carry the robot.
  const double by_hand = drive_.turned_by_hand_rad(to) - drive_.turned_by_hand_rad(seen_until_s_);
  Motion motion{drive_.travelled_m(to) - drive_.travelled_m(seen_until_s_),
                drive_.turned_rad(to) - drive_.turned_rad(seen_until_s_) - by_hand};
  seen_until_s_ = to;
  if (!acts(time_s)) return motion;
  if (faults_.odometry == Fault::kStuck) return {};
  if (faults_.odometry == Fault::kScaled)
    return {strength_ * motion.travelled_m, strength_ * motion.turned_rad};
  if (faults_.odometry == Fault::kMirrored) return {motion.travelled_m, -motion.turned_rad};
  if (faults_.odometry == Fault::kJumping && time_s >= next_jump_s_) {
    next_jump_s_ = time_s + kJumpEveryS * rng_.uniform(0.5, 1.5);
    motion.travelled_m += strength_ * rng_.uniform(-1.0, 1.0);
    motion.turned_rad += strength_ * rng_.uniform(-1.0, 1.0);
  }
  return motion;
}

double FaultyMotion::yaw_rate(double time_s, double span_s) const {
  const bool acting = acts(time_s);
  const double middle = acting && faults_.odometry == Fault::kLagging ? time_s - strength_ : time_s;
  const double rate =
      (drive_.turned_rad(middle + 0.5 * span_s) - drive_.turned_rad(middle - 0.5 * span_s)) /
      span_s;
  return acting && faults_.odometry == Fault::kMirrored ? -rate : rate;
}

}  // namespace loopstone
