#include "simulation/message_faults.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {

namespace {

/// No two stamps of a sensor are nearer together, whatever the jitter.
constexpr double kLeastStepS = 1e-6;

}  // namespace

StampErrors::StampErrors(const RealismStamps& options, double latency_s, double drift, Rng rng)
    : options_(options), latency_s_(latency_s), drift_(drift), rng_(rng) {}

double StampErrors::stamp_s(double time_s) {
  if (!options_.on) return time_s;
  const double jitter = rng_.normal() * options_.jitter_s;
  const bool is_late = rng_.uniform() < options_.late_share;
  const double late = rng_.uniform() * options_.late_s;
  const double stamp = (1.0 + drift_) * time_s + latency_s_ + jitter + (is_late ? late : 0.0);
  // Whole microseconds, so that every format keeps them.
  last_s_ = std::round(std::max(stamp, last_s_ + kLeastStepS) * 1e6) * 1e-6;
  return last_s_;
}

MessageLoss::MessageLoss(const RealismLoss& options, double duration_s, Rng rng)
    : options_(options), scans_(rng.fork(1)), odometry_(rng.fork(2)) {
  if (!options.on) return;
  Rng bursts = rng.fork(3);
  // Moments without memory: exponential times between bursts.
  const auto wait = [&] { return -options.every_s * std::log(1.0 - bursts.uniform()); };
  for (double at = wait(); at < duration_s; at += wait()) {
    const double end = at + bursts.uniform(0.1, 1.0) * options.longest_s;
    bursts_.push_back({"loss", at, end});
    at = end;
  }
}

bool MessageLoss::is_in_burst(double time_s) const {
  return std::ranges::any_of(bursts_, [&](const RealismSpoil& burst) {
    return time_s >= burst.from_s && time_s < burst.to_s;
  });
}

bool MessageLoss::is_scan_lost(double time_s) {
  if (!options_.on) return false;
  const bool is_single = scans_.uniform() < options_.share;
  return is_single || is_in_burst(time_s);
}

bool MessageLoss::is_odometry_lost(double time_s) {
  if (!options_.on || !options_.odometry_too) return false;
  const bool is_single = odometry_.uniform() < options_.share;
  return is_single || is_in_burst(time_s);
}

void MessageLoss::note(RealismRecord& record) const {
  record.spoils.insert(record.spoils.end(), bursts_.begin(), bursts_.end());
}

}  // namespace loopstone
