#include "live/live_clock.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

LiveClock::Arrival at(double seconds) {
  return LiveClock::Arrival{} + std::chrono::duration_cast<LiveClock::Arrival::duration>(
                                    std::chrono::duration<double>(seconds));
}
Stamp stamp(double seconds) { return Stamp::from_seconds(seconds); }

/// Ten a second, until a time of arrival; the last stamp that came out.
Stamp run(LiveClock& clock, double from_s, double to_s, double clock_ahead_s) {
  Stamp last{};
  for (double t = from_s; t < to_s; t += 0.1) {
    if (const auto taken = clock.take(stamp(t + clock_ahead_s), 0, at(t))) last = *taken;
  }
  return last;
}

TEST(LiveClock, LeavesStampsOfAClockThatRunsAsTheyAre) {
  LiveClock clock;
  Rng rng(3);
  for (double t = 1000.0; t < 1060.0; t += 0.1) {
    const double late_s = 0.09 * rng.uniform();
    EXPECT_EQ(clock.take(stamp(t), 0, at(t + late_s)), stamp(t));
    EXPECT_EQ(clock.take(stamp(t - 0.05), 1, at(t + late_s)), stamp(t - 0.05)) << "of another kind";
  }
  EXPECT_FALSE(clock.take_jump());
}

TEST(LiveClock, BelievesAPause) {
  LiveClock clock;
  (void)run(clock, 1000.0, 1010.0, 0.0);
  EXPECT_EQ(clock.take(stamp(5000.0), 0, at(5000.0)), stamp(5000.0));
  EXPECT_FALSE(clock.take_jump());
}

TEST(LiveClock, BelievesWhatIsReadFasterThanItWasMeasured) {
  LiveClock clock;
  for (int i = 0; i < 1000; ++i)
    EXPECT_EQ(clock.take(stamp(1000.0 + i), 0, at(1e-4 * i)), stamp(1000.0 + i));
}

TEST(LiveClock, GoesOnWhenTheClockJumps) {
  for (const double jump_s : {-3600.0, -5.0, 300.0, 1e6}) {
    LiveClock clock;
    const Stamp before = run(clock, 1e7, 1e7 + 10.0, 0.0);
    const Stamp after = run(clock, 1e7 + 10.0, 1e7 + 20.0, jump_s);
    const auto jump = clock.take_jump();
    ASSERT_TRUE(jump) << jump_s;
    EXPECT_NEAR(jump->seconds(), jump_s, 0.3);
    EXPECT_NEAR((after - before).seconds(), 10.0, 0.2) << "as much as passed";
    EXPECT_FALSE(clock.take_jump()) << "told once";
  }
}

TEST(LiveClock, PassesBrokenStampsBy) {
  LiveClock clock;
  (void)run(clock, 1000.0, 1010.0, 0.0);
  for (int i = 0; i < 100; ++i) {
    const double t = 1010.0 + i;
    const double broken_s = i % 2 == 0 ? 0.0 : 1e9 + 1e7 * i;
    EXPECT_FALSE(clock.take(stamp(broken_s), 0, at(t)));
    EXPECT_EQ(clock.take(stamp(t), 0, at(t)), stamp(t));
  }
  EXPECT_FALSE(clock.take_jump());
  EXPECT_FALSE(clock.take(Stamp{-5}, 0, at(2000.0)));
  EXPECT_FALSE(clock.take(Stamp{INT64_MAX}, 0, at(2000.0)));
}

TEST(LiveClock, NeverGoesBackInAKindWhateverComes) {
  Rng rng(11);
  for (int drive = 0; drive < 50; ++drive) {
    LiveClock clock;
    std::vector<std::optional<Stamp>> last(3);
    double arrival_s = 0.0;
    double ahead_s = 0.0;
    for (int i = 0; i < 400; ++i) {
      arrival_s += rng.uniform(0.0, 0.2);
      if (rng.below(40) == 0) ahead_s = rng.uniform(-2000.0, 2000.0);
      const double t = 5000.0 + arrival_s + ahead_s + rng.uniform(-0.5, 0.5);
      const auto kind = static_cast<std::size_t>(rng.below(3));
      const auto taken = clock.take(stamp(t), kind, at(arrival_s));
      if (!taken) continue;
      if (last[kind]) {
        EXPECT_LT(*last[kind], *taken);
      }
      last[kind] = taken;
    }
  }
}

TEST(LiveClock, LeavesOutWhatIsToldTwice) {
  LiveClock clock;
  EXPECT_TRUE(clock.take(stamp(10.0), 0, at(0.0)));
  EXPECT_FALSE(clock.take(stamp(10.0), 0, at(0.1)));
  EXPECT_TRUE(clock.take(stamp(10.0), 1, at(0.1)));
}

}  // namespace
}  // namespace loopstone
