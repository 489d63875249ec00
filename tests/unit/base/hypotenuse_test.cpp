#include "loopstone/base/hypotenuse.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A number of either sign, its exponent anywhere in [-limit, limit].
double any_number(Rng& rng, double limit) {
  const double digits = 1.0 + rng.uniform();
  const double size = std::ldexp(digits, static_cast<int>(rng.uniform(-limit, limit)));
  return rng.uniform() < 0.5 ? -size : size;
}

std::uint64_t units_apart(double a, double b) {
  const auto first = std::bit_cast<std::uint64_t>(a);
  const auto second = std::bit_cast<std::uint64_t>(b);
  return first > second ? first - second : second - first;
}

TEST(Hypotenuse, OfWholeTrianglesIsExact) {
  EXPECT_EQ(hypotenuse(3.0, 4.0), 5.0);
  EXPECT_EQ(hypotenuse(-12.0, 5.0), 13.0);
  EXPECT_EQ(hypotenuse(0.0, -7.5), 7.5);
  EXPECT_EQ(hypotenuse(0.0, 0.0), 0.0);
  EXPECT_EQ(hypotenuse(0x3p+1000, 0x4p+1000), 0x5p+1000);
  EXPECT_EQ(hypotenuse(0x3p-1070, 0x4p-1070), 0x5p-1070);
}

TEST(Hypotenuse, IsOneUnitOrLessFromTheTruth) {
  Rng rng(1);
  for (int i = 0; i < 20000; ++i) {
    const double x = any_number(rng, i % 2 == 0 ? 4.0 : 900.0);
    const double y = i % 3 == 0 ? x * rng.uniform(0.5, 2.0) : any_number(rng, 4.0);
    // std::hypot is itself within one unit.
    EXPECT_LE(units_apart(hypotenuse(x, y), std::hypot(x, y)), 1U) << x << ' ' << y;
  }
}

TEST(Hypotenuse, KnowsNoOrderAndNoSign) {
  Rng rng(2);
  for (int i = 0; i < 1000; ++i) {
    const double x = any_number(rng, 500.0);
    const double y = any_number(rng, 500.0);
    EXPECT_EQ(hypotenuse(x, y), hypotenuse(-y, x));
  }
}

TEST(Hypotenuse, OverflowsOnlyWhereTheResultDoes) {
  const double most = std::numeric_limits<double>::max();
  EXPECT_EQ(hypotenuse(most, 0.0), most);
  EXPECT_EQ(hypotenuse(most, most), kInfinity);
  EXPECT_EQ(hypotenuse(kNan, -kInfinity), kInfinity);
  EXPECT_TRUE(std::isnan(hypotenuse(kNan, 1.0)));
}

TEST(Hypotenuse, HasTheSameBitsOnEveryProcessor) {
  Rng rng(3);
  std::uint64_t digest = 14695981039346656037ULL;  // FNV-1a, 64 bits
  for (int i = 0; i < 10000; ++i) {
    const double x = any_number(rng, 20.0);
    const double y = any_number(rng, 20.0);
    digest = (digest ^ std::bit_cast<std::uint64_t>(hypotenuse(x, y))) * 1099511628211ULL;
  }
  EXPECT_EQ(digest, 0xF2759414B719C746ULL);
}

}  // namespace
}  // namespace loopstone
