#include "loopstone/base/stamp.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace loopstone {
namespace {

TEST(Stamp, RoundsToTheNearestNanosecond) {
  EXPECT_EQ(Stamp::from_seconds(1.5).nanoseconds, 1'500'000'000);
  EXPECT_EQ(Stamp::from_seconds(-0.25).nanoseconds, -250'000'000);
  EXPECT_EQ(Duration::from_seconds(0.1).nanoseconds, 100'000'000);  // 0.1 is no binary fraction
  EXPECT_EQ(Duration::from_seconds(0.6e-9).nanoseconds, 1);
  EXPECT_EQ(Duration::from_seconds(-0.6e-9).nanoseconds, -1);
}

TEST(Stamp, OrdersByTime) {
  EXPECT_LT(Stamp{-1}, Stamp{0});
  EXPECT_LT(Stamp{1'000'000'000}, Stamp{1'000'000'001});
  EXPECT_EQ(Stamp{7}, Stamp{7});
  EXPECT_GT(Duration{2}, Duration{-3});
}

TEST(Stamp, NanosecondsSurviveAtUnixTimes) {
  // A double would lose them here.
  const Stamp now{1'700'000'000'123'456'789};
  EXPECT_EQ((now + Duration{1} - now).nanoseconds, 1);
}

RC_GTEST_PROP(StampLaws, AdditionUndoesSubtraction, ()) {
  const auto nanoseconds =
      rc::gen::inRange<std::int64_t>(-4'000'000'000'000'000'000, 4'000'000'000'000'000'000);
  const Stamp a{*nanoseconds};
  const Duration d{*nanoseconds};
  RC_ASSERT((a + d) - d == a);
  RC_ASSERT((a + d) - a == d);
  RC_ASSERT((a < a + d) == (Duration{} < d));
}

RC_GTEST_PROP(StampLaws, SecondsRoundTrip, ()) {
  // Within 100 years a double keeps microseconds apart.
  const auto microseconds =
      *rc::gen::inRange<std::int64_t>(-3'000'000'000'000'000, 3'000'000'000'000'000);
  const Stamp stamp{microseconds * 1000};
  RC_ASSERT(std::abs((Stamp::from_seconds(stamp.seconds()) - stamp).nanoseconds) < 1000);
}

}  // namespace
}  // namespace loopstone
