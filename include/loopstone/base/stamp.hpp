#pragma once

#include <cmath>
#include <compare>
#include <cstdint>

namespace loopstone {

/// A span of time, signed, in whole nanoseconds.
struct Duration {
  std::int64_t nanoseconds = 0;

  [[nodiscard]] static Duration from_seconds(double seconds) {
    return {static_cast<std::int64_t>(std::llround(seconds * 1e9))};
  }
  [[nodiscard]] static constexpr Duration from_milliseconds(std::int64_t milliseconds) {
    return {milliseconds * 1'000'000};
  }
  [[nodiscard]] constexpr double seconds() const { return static_cast<double>(nanoseconds) * 1e-9; }
  friend constexpr auto operator<=>(const Duration&, const Duration&) = default;
};

/// A moment on the recording's own clock: nanoseconds since that clock's zero (often the Unix
/// epoch). A strong type, so that a stamp is never taken for a number of seconds.
struct Stamp {
  std::int64_t nanoseconds = 0;

  /// Rounded to the nearest nanosecond. A double holds about 0.2 us at today's Unix times, so
  /// parsers that need every digit build the integer themselves.
  [[nodiscard]] static Stamp from_seconds(double seconds) {
    return {static_cast<std::int64_t>(std::llround(seconds * 1e9))};
  }
  [[nodiscard]] constexpr double seconds() const { return static_cast<double>(nanoseconds) * 1e-9; }
  friend constexpr auto operator<=>(const Stamp&, const Stamp&) = default;

  template <typename Archive>
  void archive(Archive& a) {
    // Readers of logs give no more, so that differences fit, too.
    constexpr std::int64_t kMost = std::int64_t{1} << 62;
    a(nanoseconds);
    a.check(nanoseconds > -kMost && nanoseconds < kMost, "a stamp that no log has");
  }
};

[[nodiscard]] constexpr Duration operator-(Stamp later, Stamp earlier) {
  return {later.nanoseconds - earlier.nanoseconds};
}
[[nodiscard]] constexpr Duration operator+(Duration one, Duration other) {
  return {one.nanoseconds + other.nanoseconds};
}
[[nodiscard]] constexpr Duration operator-(Duration one, Duration other) {
  return {one.nanoseconds - other.nanoseconds};
}
[[nodiscard]] constexpr Stamp operator+(Stamp stamp, Duration span) {
  return {stamp.nanoseconds + span.nanoseconds};
}
[[nodiscard]] constexpr Stamp operator-(Stamp stamp, Duration span) {
  return {stamp.nanoseconds - span.nanoseconds};
}

}  // namespace loopstone
