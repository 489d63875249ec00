#include "mapping/light_rows.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "loopstone/base/linear_light.hpp"
#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

ColourImage random_picture(int width, int height, Rng& rng) {
  ColourImage picture{width, height, {}};
  for (int i = 0; i < 3 * width * height; ++i) {
    picture.rgb.push_back(static_cast<std::uint8_t>(rng.uniform(0.0, 255.999)));
  }
  return picture;
}

/// Overlap of [low, high] with pixel k.
double overlap(double low, double high, int k) {
  return std::max(0.0, std::min(high, k + 0.5) - std::max(low, k - 0.5));
}

TEST(LightRows, MeanIsThatOfEveryPixelByItsShareOfTheBox) {
  Rng rng(11);
  const ColourImage picture = random_picture(60, 40, rng);
  const auto table = linear_light_table();
  LightRows rows;
  rows.assign(picture, 0, 40);
  for (int trial = 0; trial < 500; ++trial) {
    const double width = rng.uniform(1.0, 12.0);
    const double height = rng.uniform(1.0, 9.0);
    const double u = rng.uniform(0.5 * width, 59.0 - 0.5 * width);
    const double v = rng.uniform(0.5 * height, 39.0 - 0.5 * height);
    std::array<double, 3> sum{};
    for (int row = 0; row < 40; ++row) {
      for (int column = 0; column < 60; ++column) {
        const double share = overlap(u - 0.5 * width, u + 0.5 * width, column) *
                             overlap(v - 0.5 * height, v + 0.5 * height, row);
        for (std::size_t c = 0; c < 3; ++c) sum[c] += share * table[picture.at(column, row)[c]];
      }
    }
    const LinearRgb mean = rows.mean(static_cast<float>(u), static_cast<float>(v),
                                     static_cast<float>(width), static_cast<float>(height));
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(mean[c], sum[c] / (width * height), 8.0);
  }
}

TEST(LightRows, ABoxOfOnePixelInterpolates) {
  ColourImage picture{3, 3, std::vector<std::uint8_t>(27, 0)};
  for (std::size_t c = 0; c < 3; ++c) picture.rgb[3 * (1 * 3 + 1) + c] = 255;
  LightRows rows;
  rows.assign(picture, 0, 3);
  EXPECT_NEAR(rows.mean(1.0F, 1.0F, 1.0F, 1.0F)[0], 65535.0, 8.0);
  EXPECT_NEAR(rows.mean(0.5F, 1.0F, 1.0F, 1.0F)[0], 0.5 * 65535.0, 8.0);
  EXPECT_NEAR(rows.mean(0.75F, 0.5F, 1.0F, 1.0F)[1], 0.375 * 65535.0, 8.0);
}

TEST(LinearLight, ByteValuesSurviveTheWayThere) {
  const auto light = linear_light_table();
  const auto srgb = srgb_table();
  for (std::size_t i = 0; i < 256; ++i) EXPECT_EQ(srgb[light[i]], i);
  EXPECT_EQ(light[255], 65535);
  EXPECT_NEAR(linear_of_srgb(0.5), 0.21404114, 1e-7);  // IEC 61966-2-1
  EXPECT_NEAR(srgb_of_linear(linear_of_srgb(0.02)), 0.02, 1e-12);
}

}  // namespace
}  // namespace loopstone
