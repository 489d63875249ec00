// How far a wheel turned, by what drivers say of it.

#include "formats/wheel_angle.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

constexpr double kMostRadS = 200.0;

Stamp at(double seconds) { return Stamp::from_seconds(1000.0 + seconds); }

TEST(WheelAngle, PositionsAreCountedFromTheFirst) {
  WheelAngle wheel(kMostRadS);
  EXPECT_FALSE(wheel.has_moved());
  for (int i = 0; i <= 100; ++i) wheel.add(at(0.1 * i), 500.0 + 0.5 * i, {});
  EXPECT_NEAR(wheel.by_position_rad(), 50.0, 1e-9);
  EXPECT_FALSE(wheel.needs_speed());
  EXPECT_TRUE(wheel.has_moved());
  wheel.add(at(9.0), 0.0, {});  // late
  EXPECT_NEAR(wheel.by_position_rad(), 50.0, 1e-9);
}

TEST(WheelAngle, TurnsAreAddedWhereADriverBeginsAgain) {
  for (const double speed : {2.0, -2.0, 12.0, 25.0, -25.0}) {
    for (const bool from_zero : {true, false}) {
      for (const bool tells_speed : {true, false}) {
        WheelAngle wheel(kMostRadS);
        for (int i = 0; i <= 200; ++i) {
          const double angle = wrap_angle(0.1 * i * speed);
          const double told = from_zero && angle < 0.0 ? angle + 2.0 * kPi : angle;
          wheel.add(at(0.1 * i), told, tells_speed ? std::optional(speed) : std::nullopt);
        }
        EXPECT_NEAR(wheel.by_position_rad(), 20.0 * speed, 1e-6)
            << speed << " from zero " << from_zero << " tells speed " << tells_speed;
        EXPECT_EQ(wheel.resets(), 0);
      }
    }
  }
}

TEST(WheelAngle, AFastWheelThatCountsOnIsNotWrapped) {
  // 4 rad a reading: each step is more than half a turn.
  WheelAngle wheel(kMostRadS);
  for (int i = 0; i <= 20; ++i) wheel.add(at(0.1 * i), 4.0 * i, 40.0);
  EXPECT_NEAR(wheel.by_position_rad(), 80.0, 1e-9);
}

TEST(WheelAngle, SpeedsCountWherePositionsAreMissingOrStandStill) {
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  for (const std::optional<double> position : {std::optional<double>{}, {nothing}, {0.0}, {1.5}}) {
    WheelAngle wheel(kMostRadS);
    for (int i = 0; i <= 100; ++i) wheel.add(at(0.02 * i), position, 0.1 * i);
    EXPECT_TRUE(wheel.needs_speed());
    EXPECT_NEAR(wheel.by_speed_rad(), 10.0, 1e-9);  // half of 10 rad/s over 2 s
  }
  WheelAngle standing(kMostRadS);
  for (int i = 0; i <= 100; ++i) standing.add(at(0.02 * i), 1.5, 0.0);
  EXPECT_FALSE(standing.needs_speed());
  EXPECT_FALSE(standing.has_moved());
}

TEST(WheelAngle, NobodyKnowsTheSpeedAcrossALongGap) {
  WheelAngle wheel(kMostRadS);
  wheel.add(at(0.0), {}, 5.0);
  wheel.add(at(1.0), {}, 5.0);
  wheel.add(at(31.0), {}, 5.0);
  EXPECT_NEAR(wheel.by_speed_rad(), 5.0, 1e-9);
}

TEST(WheelAngle, ADriverThatBeganAnewIsNoMotion) {
  for (const bool tells_speed : {true, false}) {
    WheelAngle wheel(kMostRadS);
    const auto speed = tells_speed ? std::optional(5.0) : std::nullopt;
    for (int i = 0; i <= 10; ++i) wheel.add(at(0.1 * i), 1000.0 + 0.5 * i, speed);
    for (int i = 11; i <= 20; ++i) wheel.add(at(0.1 * i), 0.5 * (i - 11), speed);
    EXPECT_EQ(wheel.resets(), 1);
    EXPECT_NEAR(wheel.by_position_rad(), tells_speed ? 10.0 : 9.5, 1e-9);
  }
}

TEST(WheelCount, CountersWrapAtTheirWidth) {
  for (const int bits : {16, 32}) {
    for (const int step : {700, -700}) {
      WheelCount wheel(bits, true);
      std::int64_t count = 0;
      for (int i = 0; i <= 1000; ++i) {
        const auto told = bits == 16 ? static_cast<std::int64_t>(static_cast<std::uint16_t>(count))
                                     : static_cast<std::int64_t>(static_cast<std::int32_t>(count));
        wheel.add(at(0.02 * i), told, 1e6);
        count += step;
      }
      EXPECT_EQ(wheel.total(), 1000 * step) << bits;
      EXPECT_EQ(wheel.resets(), 0);
    }
  }
}

TEST(WheelCount, CountsSinceTheLastReading) {
  WheelCount wheel(62, false);
  for (int i = 0; i <= 10; ++i) wheel.add(at(0.1 * i), 7, 1e6);
  EXPECT_EQ(wheel.total(), 70);  // what the first one counted happened before
}

TEST(WheelCount, JumpsThatNoWheelMakesAreLeftOut) {
  WheelCount wheel(32, true);
  wheel.add(at(0.0), 100'000, 1000.0);
  wheel.add(at(0.1), 100'050, 1000.0);
  wheel.add(at(0.2), 0, 1000.0);
  wheel.add(at(0.3), 50, 1000.0);
  EXPECT_EQ(wheel.total(), 100);
  EXPECT_EQ(wheel.resets(), 1);
}

}  // namespace
}  // namespace loopstone
