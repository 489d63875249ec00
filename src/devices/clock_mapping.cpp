#include "devices/clock_mapping.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <vector>

namespace loopstone {
namespace {

/// Slewing changes a clock by 0.5 ms a second; whoever sets it does so for more than this.
constexpr std::int64_t kJumpNs = 100'000'000;
/// A network may hold scans back for so long.
constexpr std::int64_t kPatienceNs = 2'000'000'000;
/// And clocks may differ by this share of the time between two readings.
constexpr std::int64_t kRateShare = 100;

std::int64_t nanoseconds(double seconds) { return std::llround(seconds * 1e9); }

}  // namespace

// Who is interrupted between the two clocks takes one for later than the other; so the time of day
// is read between two looks at the steady clock, and again when they are far apart.
HostTime HostTime::now() {
  constexpr std::int64_t kClose_ns = 5'000;
  constexpr int kTries = 8;
  const auto count = [](auto moment) {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(moment.time_since_epoch()).count();
  };
  HostTime best;
  std::int64_t best_ns = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < kTries && best_ns > kClose_ns; ++i) {
    const std::int64_t before_ns = count(std::chrono::steady_clock::now());
    const std::int64_t system_ns = count(std::chrono::system_clock::now());
    const std::int64_t took_ns = count(std::chrono::steady_clock::now()) - before_ns;
    if (took_ns >= best_ns) continue;
    best_ns = took_ns;
    best = {before_ns + took_ns / 2, system_ns};
  }
  return best;
}

void HostClock::hear(const HostTime& now) {
  const std::int64_t offset_ns = now.system_ns - now.steady_ns;
  const std::int64_t change_ns = offset_ns_ ? offset_ns - *offset_ns_ : 0;
  if (std::abs(change_ns) > kJumpNs) jumped_ns_ += change_ns;
  offset_ns_ = offset_ns;
}

std::int64_t HostClock::system_ns(std::int64_t steady_ns) const {
  return steady_ns + offset_ns_.value_or(0) - jumped_ns_;
}

WrappingClock::Reading WrappingClock::read(std::int64_t count, std::int64_t steady_ns) {
  if (!last_) {
    last_ = Last{count, count * tick_ns_, steady_ns};
    return {last_->device_ns, true};
  }
  const std::int64_t elapsed_ns = steady_ns - last_->steady_ns;
  const std::int64_t round_ns = modulus_ * tick_ns_;
  std::int64_t step_ns = ((count - last_->count + modulus_) % modulus_) * tick_ns_;
  // Somebody who was silent for hours: as many rounds as fit best.
  step_ns += std::max<std::int64_t>(0, (elapsed_ns - step_ns + round_ns / 2) / round_ns) * round_ns;
  const bool is_new = std::abs(step_ns - elapsed_ns) > kPatienceNs + elapsed_ns / kRateShare;
  last_ = Last{count, is_new ? count * tick_ns_ : last_->device_ns + step_ns, steady_ns};
  return {last_->device_ns, is_new};
}

void ClockMapping::hear(std::int64_t device_ns, std::int64_t steady_ns) {
  const Heard heard{device_ns, steady_ns - device_ns};
  if (window_.empty() || device_ns - bucket_began_ns_ >= nanoseconds(numbers_.bucket_s)) {
    bucket_began_ns_ = device_ns;
    window_.push_back(heard);
  } else if (heard.delay_ns < window_.back().delay_ns) {
    window_.back() = heard;
  }
  while (device_ns - window_.front().device_ns > nanoseconds(numbers_.window_s))
    window_.pop_front();
  fit();
}

std::int64_t ClockMapping::steady_ns(std::int64_t device_ns) const {
  const auto away_ns = static_cast<double>(device_ns - touched_.device_ns);
  return device_ns + touched_.delay_ns + std::llround(slope_ * away_ns);
}

void ClockMapping::forget() {
  window_.clear();
  touched_ = {};
}

/// Of the lower hull the edge over the middle of the window.
double ClockMapping::hull_slope() const {
  const auto slope = [](const Heard& a, const Heard& b) {
    return static_cast<double>(b.delay_ns - a.delay_ns) /
           static_cast<double>(b.device_ns - a.device_ns);
  };
  std::vector<Heard> hull;
  for (const Heard& heard : window_) {
    while (hull.size() >= 2 &&
           slope(hull[hull.size() - 2], hull.back()) >= slope(hull.back(), heard)) {
      hull.pop_back();
    }
    hull.push_back(heard);
  }
  double middle_ns = 0.0;
  for (const Heard& heard : window_) {
    middle_ns += static_cast<double>(heard.device_ns - window_.front().device_ns) /
                 static_cast<double>(window_.size());
  }
  std::size_t right = 1;
  while (right + 1 < hull.size() &&
         static_cast<double>(hull[right].device_ns - window_.front().device_ns) < middle_ns) {
    ++right;
  }
  return slope(hull[right - 1], hull[right]);
}

void ClockMapping::fit() {
  const std::int64_t seen_ns = window_.back().device_ns - window_.front().device_ns;
  if (seen_ns >= nanoseconds(numbers_.rate_after_s))
    slope_ = std::clamp(hull_slope(), -numbers_.rate_error_max, numbers_.rate_error_max);
  const auto height = [&](const Heard& heard) {
    return static_cast<double>(heard.delay_ns - window_.front().delay_ns) -
           slope_ * static_cast<double>(heard.device_ns - window_.front().device_ns);
  };
  touched_ = *std::min_element(window_.begin(), window_.end(), [&](const Heard& a, const Heard& b) {
    return height(a) < height(b);
  });
}

}  // namespace loopstone
