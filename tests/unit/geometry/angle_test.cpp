#include "loopstone/geometry/angle.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>

#include "support/generators.hpp"

namespace loopstone {
namespace {

TEST(WrapAngle, KeepsPiAndTurnsMinusPiIntoIt) {
  EXPECT_EQ(wrap_angle(kPi), kPi);
  EXPECT_EQ(wrap_angle(-kPi), kPi);
  EXPECT_EQ(wrap_angle(3.0 * kPi), kPi);
  EXPECT_EQ(wrap_angle(-3.0 * kPi), kPi);
  EXPECT_EQ(wrap_angle(2.0 * kPi), 0.0);
  EXPECT_EQ(wrap_angle(std::nextafter(-kPi, 0.0)), std::nextafter(-kPi, 0.0));
  EXPECT_LT(wrap_angle(std::nextafter(kPi, 4.0)), 0.0);
}

TEST(WrapAngle, PassesOnWhatIsNoAngle) {
  EXPECT_TRUE(std::isnan(wrap_angle(NAN)));
  EXPECT_TRUE(std::isnan(wrap_angle(std::numeric_limits<double>::infinity())));
}

TEST(WrapAngle, DegreesAndBack) {
  EXPECT_DOUBLE_EQ(radians(180.0), kPi);
  EXPECT_DOUBLE_EQ(degrees(kPi / 6.0), 30.0);
}

RC_GTEST_PROP(WrapAngleLaws, StaysInRangeAndMeansTheSame, ()) {
  const double angle = *test::between(-1000.0, 1000.0);
  const double wrapped = wrap_angle(angle);
  RC_ASSERT(wrapped > -kPi && wrapped <= kPi);
  RC_ASSERT(std::abs(std::cos(wrapped) - std::cos(angle)) < 1e-12);
  RC_ASSERT(std::abs(std::sin(wrapped) - std::sin(angle)) < 1e-12);
  RC_ASSERT(wrap_angle(wrapped) == wrapped);
}

}  // namespace
}  // namespace loopstone
