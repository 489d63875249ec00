#include "devices/clock_mapping.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kSecond = 1'000 * kMs;
/// Of the host's clock at the device's zero.
constexpr std::int64_t kOffset = 12'345 * kSecond;

/// Hears a device every 25 ms; tells the largest error of its times, seen from the least delay,
/// from some second on.
struct Drive {
  ClockMapping mapping{ClockMapping::Numbers{}};
  double rate_error = 0.0;
  double jitter_ms = 0.0;
  Rng rng{7};
  std::int64_t device_ns = 0;

  std::int64_t truth(std::int64_t at_ns) const {
    return kOffset + at_ns + std::llround(rate_error * static_cast<double>(at_ns));
  }
  double worst_ms(double from_s, double to_s) {
    double worst = 0.0;
    for (; device_ns < std::llround(to_s * 1e9); device_ns += 25 * kMs) {
      // Often prompt, sometimes late by much.
      const double late_ms = jitter_ms * std::pow(rng.uniform(), 3.0);
      mapping.hear(device_ns, truth(device_ns) + std::llround(late_ms * 1e6));
      if (static_cast<double>(device_ns) * 1e-9 < from_s) continue;
      const auto error_ns = mapping.steady_ns(device_ns) - truth(device_ns);
      worst = std::max(worst, std::abs(static_cast<double>(error_ns)) * 1e-6);
    }
    return worst;
  }
};

TEST(ClockMapping, IsExactWithoutJitter) {
  Drive drive;
  EXPECT_EQ(drive.worst_ms(0.0, 60.0), 0.0);
  EXPECT_DOUBLE_EQ(drive.mapping.rate(), 1.0);
}

TEST(ClockMapping, LeavesJitterOut) {
  Drive drive{.jitter_ms = 40.0};
  // 40 scans a second, of which one in ten is late by less than 0.04 ms.
  EXPECT_LT(drive.worst_ms(5.0, 120.0), 0.5);
}

TEST(ClockMapping, FollowsAClockThatDrifts) {
  Drive drive{.rate_error = 3e-4, .jitter_ms = 10.0};
  // Without the rate it would lag behind by 6 ms over its window.
  EXPECT_LT(drive.worst_ms(10.0, 200.0), 0.5);
  EXPECT_NEAR(drive.mapping.rate(), 1.0 + 3e-4, 3e-5);
}

TEST(ClockMapping, FollowsAClockThatIsTooSlow) {
  Drive drive{.rate_error = -3e-4, .jitter_ms = 10.0};
  EXPECT_LT(drive.worst_ms(10.0, 200.0), 0.5);
}

TEST(ClockMapping, BelievesNoRateThatQuartzDoesNotHave) {
  Drive drive{.rate_error = 0.01};
  (void)drive.worst_ms(0.0, 60.0);
  EXPECT_DOUBLE_EQ(drive.mapping.rate(), 1.001);
}

TEST(ClockMapping, BeginsAnewWhenTheDeviceDoes) {
  Drive drive{.jitter_ms = 5.0};
  (void)drive.worst_ms(0.0, 30.0);
  drive.mapping.forget();
  // 30 s later the device's clock is at 0 again.
  drive.mapping.hear(0, kOffset + 30 * kSecond);
  EXPECT_NEAR(static_cast<double>(drive.mapping.steady_ns(25 * kMs) - kOffset - 30 * kSecond),
              25.0 * kMs, 0.1 * kMs);
}

TEST(ClockMapping, ForgetsDelaysThatAreOverWithTheWindow) {
  // A network that becomes slower for good by 8 ms.
  ClockMapping mapping{ClockMapping::Numbers{}};
  std::int64_t device_ns = 0;
  for (; device_ns < 30 * kSecond; device_ns += 25 * kMs)
    mapping.hear(device_ns, kOffset + device_ns);
  for (; device_ns < 90 * kSecond; device_ns += 25 * kMs)
    mapping.hear(device_ns, kOffset + device_ns + 8 * kMs);
  EXPECT_NEAR(static_cast<double>(mapping.steady_ns(device_ns) - kOffset - device_ns), 8.0 * kMs,
              0.01 * kMs);
}

TEST(WrappingClock, GoesOnWhereTheCounterWraps) {
  WrappingClock clock(1 << 24, kMs);
  const std::int64_t first = (1 << 24) - 10;
  EXPECT_TRUE(clock.read(first, kOffset).is_new);
  const auto before = clock.read(first + 9, kOffset + 9 * kMs);
  const auto after = clock.read(3, kOffset + 13 * kMs);
  EXPECT_FALSE(before.is_new);
  EXPECT_FALSE(after.is_new);
  EXPECT_EQ(after.device_ns - before.device_ns, 4 * kMs);
}

TEST(WrappingClock, CountsRoundsThatNobodySaw) {
  WrappingClock clock(1000, kMs);
  (void)clock.read(400, 0);
  const auto later = clock.read(500, 7'100 * kMs);
  EXPECT_FALSE(later.is_new);
  EXPECT_EQ(later.device_ns, 7'500 * kMs);
}

TEST(WrappingClock, TellsARestart) {
  WrappingClock clock(1 << 24, kMs);
  (void)clock.read(500'000, kOffset);
  const auto restarted = clock.read(40, kOffset + 25 * kMs);
  EXPECT_TRUE(restarted.is_new);
  EXPECT_EQ(restarted.device_ns, 40 * kMs);
  EXPECT_FALSE(clock.read(65, kOffset + 50 * kMs).is_new);
}

TEST(WrappingClock, TakesNoStallOfTheNetworkForARestart) {
  WrappingClock clock(1 << 24, kMs);
  (void)clock.read(1'000, kOffset);
  // Held back for 1.5 s, then all at once.
  for (int i = 1; i < 60; ++i)
    EXPECT_FALSE(clock.read(1'000 + 25 * i, kOffset + 1'500 * kMs + i).is_new) << i;
}

TEST(HostClock, FollowsSlewing) {
  HostClock clock;
  for (int i = 0; i <= 1000; ++i)
    clock.hear({i * 100 * kMs, kOffset + i * 100 * kMs + i * kMs / 20});
  EXPECT_EQ(clock.system_ns(100 * kSecond), kOffset + 100 * kSecond + 50 * kMs);
}

TEST(HostClock, GoesOnWhenTheTimeOfDayIsSet) {
  HostClock clock;
  clock.hear({0, kOffset});
  clock.hear({kSecond, kOffset + kSecond});
  for (const std::int64_t jump : {3'600 * kSecond, -7 * kSecond, kSecond / 2}) {
    clock.hear({2 * kSecond, kOffset + 2 * kSecond + jump});
    EXPECT_EQ(clock.system_ns(2 * kSecond), kOffset + 2 * kSecond) << jump;
    clock.hear({3 * kSecond, kOffset + 3 * kSecond + jump});
    EXPECT_EQ(clock.system_ns(3 * kSecond), kOffset + 3 * kSecond) << jump;
    clock.hear({3 * kSecond, kOffset + 3 * kSecond});
  }
}

TEST(HostTime, BothClocksAreReadAtOnce) {
  const HostTime first = HostTime::now();
  const HostTime second = HostTime::now();
  EXPECT_LE(first.steady_ns, second.steady_ns);
}

}  // namespace
}  // namespace loopstone
