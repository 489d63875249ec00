#include "mapping/texture_cell.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

LinearRgb grey(float value) { return {value, value, value}; }

/// The naive twin: keeps all samples.
float weighted_median(std::vector<std::pair<float, float>> value_and_weight) {
  std::sort(value_and_weight.begin(), value_and_weight.end());
  float total = 0.0F;
  for (const auto& [value, weight] : value_and_weight) total += weight;
  float sum = 0.0F;
  for (const auto& [value, weight] : value_and_weight) {
    sum += weight;
    if (2.0F * sum >= total) return value;
  }
  return 0.0F;
}

TEST(TextureCell, OneColourIsItsWeightedMean) {
  TextureCell cell;
  EXPECT_FALSE(cell.seen());
  cell.add({10000.0F, 20000.0F, 30000.0F}, 0.25F);
  cell.add({10400.0F, 20400.0F, 30400.0F}, 0.75F);
  EXPECT_TRUE(cell.seen());
  EXPECT_NEAR(cell.best.rgb[0], 10300, 1);
  EXPECT_NEAR(cell.best.rgb[1], 20300, 1);
  EXPECT_NEAR(cell.best.rgb[2], 30300, 1);
  EXPECT_EQ(cell.best.weight, 256);
  EXPECT_EQ(cell.rival.weight, 0);
}

TEST(TextureCell, AgreesWithTheMedianOfAllSamplesWhateverTheirOrder) {
  Rng rng(3);
  for (int trial = 0; trial < 300; ++trial) {
    const float truth = static_cast<float>(rng.uniform(3000.0, 60000.0));
    const double outliers = rng.uniform(0.0, 0.4);
    TextureCell cell;
    std::vector<std::pair<float, float>> samples;
    for (int i = 0; i < 60; ++i) {
      const bool is_outlier = rng.uniform() < outliers;
      const double noisy = truth * (1.0 + 0.05 * rng.normal(0.0, 1.0));
      const auto value = static_cast<float>(is_outlier ? rng.uniform(0.0, 65535.0) : noisy);
      const auto weight = static_cast<float>(rng.uniform(0.05, 1.0));
      cell.add(grey(std::clamp(value, 0.0F, 65535.0F)), weight);
      samples.emplace_back(value, weight);
    }
    EXPECT_NEAR(cell.best.rgb[0], weighted_median(samples), 0.1 * truth + 800.0);
  }
}

TEST(TextureCell, AFewFramesOfSomethingElseFirstLeaveNoTrace) {
  TextureCell cell;
  for (int i = 0; i < 5; ++i) cell.add({60000.0F, 2000.0F, 2000.0F}, 1.0F);
  for (int i = 0; i < 8; ++i) cell.add(grey(20000.0F), 1.0F);
  EXPECT_EQ(cell.best.rgb[0], 20000);
  EXPECT_EQ(cell.best.rgb[1], 20000);
}

TEST(TextureCell, ManySamplesDoNotOverflow) {
  TextureCell cell;
  for (int i = 0; i < 5000; ++i) cell.add(grey(30000.0F), 1.0F);
  EXPECT_EQ(cell.best.weight, 65535);
  EXPECT_EQ(cell.best.rgb[0], 30000);
  for (int i = 0; i < 5000; ++i) cell.add(grey(33000.0F), 1.0F);
  EXPECT_NEAR(cell.best.rgb[0], 33000, 150);  // late samples still count
}

}  // namespace
}  // namespace loopstone
