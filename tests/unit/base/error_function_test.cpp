#include "loopstone/base/error_function.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace loopstone {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Abramowitz and Stegun 1964, table 7.1.
TEST(ErrorFunction, AgreesWithTables) {
  EXPECT_NEAR(error_function(0.1), 0.1124629160, 1e-10);
  EXPECT_NEAR(error_function(0.5), 0.5204998778, 1e-10);
  EXPECT_NEAR(error_function(-1.0), -0.8427007929, 1e-10);
  EXPECT_NEAR(error_function(1.9), 0.9927904292, 1e-10);
  EXPECT_NEAR(complementary_error_function(2.0), 0.004677734981, 1e-12);
}

TEST(ErrorFunction, AgreesWithTheStandardLibrary) {
  for (double x = -7.0; x < 7.0; x += 1.0 / 1024.0) {
    const double erf = std::erf(x);
    const double erfc = std::erfc(x);
    EXPECT_NEAR(error_function(x), erf, 1e-15 * std::abs(erf)) << x;
    EXPECT_NEAR(complementary_error_function(x), erfc, 1e-15 * erfc) << x;
  }
  for (double x = 7.0; x < 26.0; x += 0.125)
    EXPECT_NEAR(complementary_error_function(x), std::erfc(x), 1e-15 * std::erfc(x)) << x;
}

TEST(ErrorFunction, EndsWhereItMust) {
  EXPECT_EQ(error_function(0.0), 0.0);
  EXPECT_EQ(error_function(kInfinity), 1.0);
  EXPECT_EQ(error_function(-kInfinity), -1.0);
  EXPECT_EQ(complementary_error_function(kInfinity), 0.0);
  EXPECT_EQ(complementary_error_function(-kInfinity), 2.0);
  EXPECT_TRUE(std::isnan(error_function(kNan)));
  EXPECT_TRUE(std::isnan(complementary_error_function(kNan)));
}

TEST(ErrorFunction, DoesNotFallWhereOneFormulaFollowsAnother) {
  for (const double at : {0.46875, 4.0}) {
    double before = error_function(at - 1e-6);
    for (double x = at - 1e-6; x < at + 1e-6; x += 1e-9) {
      EXPECT_GE(error_function(x), before) << x;
      before = error_function(x);
    }
  }
}

}  // namespace
}  // namespace loopstone
