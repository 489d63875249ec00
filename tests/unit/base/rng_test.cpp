#include "loopstone/base/rng.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>
#include <vector>

namespace loopstone {
namespace {

static_assert(std::uniform_random_bit_generator<Rng>);

TEST(Rng, GivesTheNumbersOfThePublishedAlgorithm) {
  // Computed apart from this code, from Blackman and Vigna's definitions of splitmix64 and
  // xoshiro256**.
  Rng zero(0);
  EXPECT_EQ(zero(), 0x99ec5f36cb75f2b4U);
  EXPECT_EQ(zero(), 0xbf6e1f784956452aU);
  EXPECT_EQ(zero(), 0x1a5f849d4933e6e0U);
  EXPECT_EQ(zero(), 0x6aa594f1262d2d2cU);
  Rng other(42);
  EXPECT_EQ(other(), 0x15780b2e0c2ec716U);
  EXPECT_EQ(other(), 0x6104d9866d113a7eU);
}

TEST(Rng, ForksDependOnSeedAndStreamAlone) {
  Rng used(7);
  for (int i = 0; i < 100; ++i) (void)used();
  EXPECT_EQ(used.fork(3)(), Rng(7).fork(3)());

  std::set<std::uint64_t> firsts;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    firsts.insert(Rng(seed)());
    for (std::uint64_t stream = 0; stream < 50; ++stream) firsts.insert(Rng(seed).fork(stream)());
  }
  EXPECT_EQ(firsts.size(), 20U * 51U) << "two streams start alike";
}

TEST(Rng, UniformStaysInItsInterval) {
  Rng rng(1);
  double sum = 0.0;
  constexpr int kCount = 100'000;
  for (int i = 0; i < kCount; ++i) {
    const double value = rng.uniform();
    ASSERT_GE(value, 0.0);
    ASSERT_LT(value, 1.0);
    sum += value;
    const double wide = rng.uniform(-3.0, 5.0);
    ASSERT_GE(wide, -3.0);
    ASSERT_LT(wide, 5.0);
  }
  EXPECT_NEAR(sum / kCount, 0.5, 5.0 * std::sqrt(1.0 / 12.0 / kCount));
}

TEST(Rng, BelowIsUniformOverItsValues) {
  Rng rng(2);
  std::array<int, 7> seen{};
  constexpr int kCount = 70'000;
  for (int i = 0; i < kCount; ++i) ++seen.at(rng.below(7));
  double chi2 = 0.0;
  for (const int n : seen) chi2 += (n - 10'000.0) * (n - 10'000.0) / 10'000.0;
  EXPECT_LT(chi2, 22.5);  // 6 degrees of freedom, 0.1 %
  for (int i = 0; i < 100; ++i) EXPECT_EQ(rng.below(1), 0U);
}

TEST(Rng, NormalHasItsMoments) {
  Rng rng(3);
  constexpr int kCount = 200'000;
  std::vector<double> values;
  for (int i = 0; i < kCount; ++i) values.push_back(rng.normal(2.0, 3.0));
  double mean = 0.0;
  for (const double v : values) mean += v / kCount;
  double variance = 0.0;
  double fourth = 0.0;
  for (const double v : values) {
    variance += std::pow(v - mean, 2) / kCount;
    fourth += std::pow(v - mean, 4) / kCount;
  }
  EXPECT_NEAR(mean, 2.0, 5.0 * 3.0 / std::sqrt(kCount));
  EXPECT_NEAR(variance, 9.0, 5.0 * 9.0 * std::sqrt(2.0 / kCount));
  EXPECT_NEAR(fourth / (variance * variance), 3.0, 0.1);
  const auto within =
      std::count_if(values.begin(), values.end(), [](double v) { return std::abs(v - 2.0) < 3.0; });
  EXPECT_NEAR(static_cast<double>(within) / kCount, 0.6827, 0.005);
}

}  // namespace
}  // namespace loopstone
