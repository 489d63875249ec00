#include "live/live_clock.hpp"

#include <algorithm>
#include <utility>

namespace loopstone {
namespace {

/// Between a clock's last stamp and its first after a jump, at least.
constexpr Duration kStep{1'000'000};

Duration between(LiveClock::Arrival before, LiveClock::Arrival after) {
  return Duration{std::chrono::duration_cast<std::chrono::nanoseconds>(after - before).count()};
}

}  // namespace

std::optional<Stamp> LiveClock::take(Stamp stamp, std::size_t kind, Arrival arrived) {
  // So that sums of two fit; the year 2116.
  constexpr std::int64_t kMost = std::int64_t{1} << 62;
  if (stamp.nanoseconds < 0 || stamp.nanoseconds >= kMost) return {};
  if (last_ && has_jumped(stamp + shift_, kind, arrived)) {
    if (!is_believed(stamp, arrived)) return {};
    const Stamp goes_on = last_->stamp + std::max(between(last_->arrived, arrived), kStep);
    const Duration shift = goes_on - stamp;
    jump_ = Duration{shift_.nanoseconds - shift.nanoseconds};
    shift_ = shift;
  }
  doubt_ = {};
  const Stamp now = stamp + shift_;
  const auto [last, is_first] = last_of_kind_.try_emplace(kind, now);
  if (!is_first) {
    if (now <= last->second) return {};
    last->second = now;
  }
  if (!last_ || now > last_->stamp) last_ = Last{now, arrived};
  return now;
}

bool LiveClock::has_jumped(Stamp now, std::size_t kind, Arrival arrived) const {
  const auto last = last_of_kind_.find(kind);
  const Stamp before = last == last_of_kind_.end() ? last_->stamp : last->second;
  if (now + kBack < before) return true;
  return now > last_->stamp + between(last_->arrived, arrived) + kAhead;
}

/// Enough stamps in a row that tell of the same jump.
bool LiveClock::is_believed(Stamp stamp, Arrival arrived) {
  const bool goes_on = doubt_.count > 0 && stamp + kBack > doubt_.stamp &&
                       stamp < doubt_.stamp + between(doubt_.arrived, arrived) + kAhead;
  doubt_ = {goes_on ? doubt_.count + 1 : 1, stamp, arrived};
  return doubt_.count >= kEnough;
}

std::optional<Duration> LiveClock::take_jump() { return std::exchange(jump_, std::nullopt); }

}  // namespace loopstone
