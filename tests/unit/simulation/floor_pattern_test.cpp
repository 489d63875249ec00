#include "loopstone/simulation/floor_pattern.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "simulation/letters.hpp"

namespace loopstone {
namespace {

constexpr double kTexel = 0.01;

/// 16 x 8 texels of 1 cm with random colours.
std::vector<LinearColour> random_texels() {
  Rng rng(4);
  std::vector<LinearColour> texels;
  for (int i = 0; i < 16 * 8; ++i) {
    texels.emplace_back(static_cast<float>(rng.uniform()), static_cast<float>(rng.uniform()),
                        static_cast<float>(rng.uniform()));
  }
  return texels;
}

/// Colour by column only: white and black stripes along y, each `width` texels wide.
FloorPattern stripes(int width) {
  std::vector<LinearColour> texels;
  for (int i = 0; i < 64 * 64; ++i) {
    texels.push_back(LinearColour::Constant((i % 64) / width % 2 == 0 ? 1.0F : 0.0F));
  }
  return {64, 64, {kTexel, kTexel}, texels};
}

FloorFootprint footprint(double yaw, double along_m, double across_m) {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  const double a = along_m * along_m / 12.0;
  const double b = across_m * across_m / 12.0;
  return {static_cast<float>(c * c * a + s * s * b), static_cast<float>(c * s * (a - b)),
          static_cast<float>(s * s * a + c * c * b)};
}

TEST(FloorPattern, MeanOverARectangleIsTheSumOverItsTexelsAlsoAcrossRepetitions) {
  const auto texels = random_texels();
  const FloorPattern floor(16, 8, {kTexel, 2.0 * kTexel}, texels);
  EXPECT_NEAR(floor.period_m().x(), 0.16, 1e-12);
  EXPECT_NEAR(floor.period_m().y(), 0.16, 1e-12);
  Rng rng(1);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Vector2d low(rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0));
    const Eigen::Vector2d size(rng.uniform(0.02, 0.3), rng.uniform(0.02, 0.3));
    // A hundredth of a texel at a time.
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    constexpr int kSteps = 200;
    for (int i = 0; i < kSteps; ++i) {
      for (int j = 0; j < kSteps; ++j) {
        const double x = low.x() + (i + 0.5) / kSteps * size.x();
        const double y = low.y() + (j + 0.5) / kSteps * size.y();
        const int column = static_cast<int>(std::floor(x / kTexel)) & 15;
        const int row = static_cast<int>(std::floor(y / (2.0 * kTexel))) & 7;
        sum += texels[static_cast<std::size_t>(row * 16 + column)].cast<double>();
      }
    }
    const LinearColour expected = (sum / (kSteps * kSteps)).cast<float>();
    EXPECT_LT((floor.mean_over(Extent{low, low + size}) - expected).norm(), 0.01F);
    const Eigen::Vector2d centre = low + 0.5 * size;
    const double side = size.x();
    const LinearColour square =
        floor.mean_over(Extent{centre.array() - 0.5 * side, centre.array() + 0.5 * side});
    for (const double turn : {0.0, 0.5 * kPi}) {
      EXPECT_LT((floor.mean_over(Pose2{centre.x(), centre.y(), turn}, side) - square).norm(),
                0.35F * static_cast<float>(kTexel / side));
    }
  }
}

TEST(FloorPattern, ASmallPixelSeesATexelAndAVastOneTheMean) {
  const auto texels = random_texels();
  const FloorPattern floor(16, 8, {kTexel, kTexel}, texels);
  LinearColour mean = LinearColour::Zero();
  for (const LinearColour& texel : texels) mean += texel / static_cast<float>(texels.size());
  EXPECT_LT((floor.mean() - mean).norm(), 1e-4F);
  for (int i = 0; i < 16 * 8; ++i) {
    const Eigen::Vector2d centre((i % 16 + 0.5) * kTexel - 0.32, (i / 16 + 0.5) * kTexel + 0.8);
    EXPECT_LT(
        (floor.seen_over(centre, footprint(0.0, 1e-4, 1e-4)) - texels[static_cast<std::size_t>(i)])
            .norm(),
        1e-3F);
    EXPECT_LT((floor.seen_over(centre, footprint(0.3, 5.0, 3.0)) - mean).norm(), 1e-3F);
  }
}

TEST(FloorPattern, WhatPixelsSeeHasTheMeanOfThePatternAtEverySize) {
  const FloorPattern floor(16, 8, {kTexel, kTexel}, random_texels());
  Rng rng(8);
  for (const double size : {0.002, 0.012, 0.03, 0.07, 0.3}) {
    LinearColour sum = LinearColour::Zero();
    constexpr int kPixels = 20000;
    for (int i = 0; i < kPixels; ++i) {
      const Eigen::Vector2d point(rng.uniform(0.0, 1.6), rng.uniform(0.0, 0.8));
      sum += floor.seen_over(point, footprint(rng.uniform(0.0, 3.0), 4.0 * size, size));
    }
    EXPECT_LT((sum / static_cast<float>(kPixels) - floor.mean()).norm(), 0.008F) << size;
  }
}

TEST(FloorPattern, ALongFootprintAveragesAlongItselfOnly) {
  const FloorPattern floor = stripes(4);
  const Eigen::Vector2d in_white(0.02, 0.3);
  const Eigen::Vector2d in_black(0.06, 0.3);
  // Along the stripes they stay sharp, across they are grey, between the two in between.
  EXPECT_GT(floor.seen_over(in_white, footprint(0.5 * kPi, 0.16, 0.01)).x(), 0.98F);
  EXPECT_LT(floor.seen_over(in_black, footprint(0.5 * kPi, 0.16, 0.01)).x(), 0.02F);
  EXPECT_NEAR(floor.seen_over(in_white, footprint(0.0, 0.16, 0.02)).x(), 0.5F, 0.03F);
  EXPECT_NEAR(floor.seen_over(in_black, footprint(0.0, 0.16, 0.02)).x(), 0.5F, 0.03F);
  const float slanted = floor.seen_over(in_white, footprint(0.5 * kPi - 0.2, 0.16, 0.01)).x();
  EXPECT_GT(slanted, 0.7F);
  EXPECT_FLOAT_EQ(slanted, floor.seen_over(in_white, footprint(0.5 * kPi + 0.2, 0.16, 0.01)).x());
}

TEST(FloorPattern, LettersAreWhereItSaysTheyAre) {
  const FloorPattern floor = make_floor("text", 1);
  const Extent page{{-1.0, 10.0}, {2.0, 12.0}};
  const auto letters = floor.letters_in(page);
  ASSERT_GT(letters.size(), 200U);
  double usual = 0.0;
  for (const FloorLetter& letter : letters) {
    const double dot = letter.height_m / kLetterRows;
    if (std::abs(letter.height_m - 0.05) < 1e-9) usual += 1.0;
    for (int row = 0; row < kLetterRows; ++row) {
      for (int column = 0; column < kLetterColumns; ++column) {
        const Eigen::Vector2d middle =
            letter.map_T_letter *
            Eigen::Vector2d((column + 0.5) * dot, (kLetterRows - 1 - row + 0.5) * dot);
        const float light =
            floor.mean_over(Extent{middle.array() - 0.25 * dot, middle.array() + 0.25 * dot}).y();
        if (is_inked(letter.letter, column, row)) {
          EXPECT_LT(light, 0.25F) << letter.letter;
        } else {
          EXPECT_GT(light, 0.35F) << letter.letter;
        }
      }
    }
  }
  EXPECT_GT(usual, 0.4 * static_cast<double>(letters.size()));
}

TEST(FloorPattern, APictureLiesUprightAndRepeats) {
  // 3 x 2 pixels: red green blue above, black white grey below.
  const ColourImage picture{
      3, 2, {255, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 128, 128, 128}};
  const FloorPattern floor = make_floor(picture, 3.0);
  const auto at = [&](double x, double y) {
    return floor.mean_over(Extent{{x - 0.1, y - 0.1}, {x + 0.1, y + 0.1}});
  };
  EXPECT_LT((at(0.3, 1.5) - LinearColour(1.0F, 0.0F, 0.0F)).norm(), 0.01F);
  EXPECT_LT((at(2.7, 1.5) - LinearColour(0.0F, 0.0F, 1.0F)).norm(), 0.01F);
  EXPECT_LT((at(0.3, 0.5) - LinearColour(0.0F, 0.0F, 0.0F)).norm(), 0.01F);
  EXPECT_LT((at(2.7 - 6.0, 0.5 + 4.0) - LinearColour::Constant(0.2159F)).norm(), 0.01F);
  EXPECT_NEAR(floor.period_m().x(), 3.0, 1e-9);
  EXPECT_NEAR(floor.period_m().y(), 2.0, 1e-9);
}

TEST(FloorPattern, RefusesWhatMakesNoPattern) {
  EXPECT_THROW((void)make_floor("lava", 1), UsageError);
  EXPECT_THROW((void)make_floor(ColourImage{}, 1.0), UsageError);
  EXPECT_THROW((void)make_floor(ColourImage{1, 1, {0, 0, 0}}, 0.0), UsageError);
  const std::vector<LinearColour> three(3, LinearColour::Zero());
  EXPECT_THROW(FloorPattern(3, 1, {kTexel, kTexel}, three), UsageError);
}

}  // namespace
}  // namespace loopstone
