#include "report/canvas.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

const Colour kWhite = hex_colour(0xffffff);
const Colour kBlack = hex_colour(0x000000);

std::array<int, 3> pixel(const Canvas& canvas, int row, int column) {
  const Image& image = canvas.image();
  return {image.sample(row, column, 0), image.sample(row, column, 1), image.sample(row, column, 2)};
}

/// As many white pixels as would be as dark as all of it.
double ink(const Canvas& canvas) {
  double sum = 0.0;
  for (const std::uint8_t byte : canvas.image().bytes) sum += 255 - byte;
  return sum / (3.0 * 255.0);
}

TEST(Canvas, FillsWithColourAndShare) {
  Canvas canvas(10, 6, hex_colour(0x102030));
  canvas.fill_rectangle({2.0, 1.0}, 3.5, 2.0, hex_colour(0xf0e0d0));
  EXPECT_EQ(pixel(canvas, 0, 2), (std::array{0x10, 0x20, 0x30}));
  EXPECT_EQ(pixel(canvas, 1, 2), (std::array{0xf0, 0xe0, 0xd0}));
  EXPECT_EQ(pixel(canvas, 2, 4), (std::array{0xf0, 0xe0, 0xd0}));
  EXPECT_EQ(pixel(canvas, 2, 5), (std::array{0x80, 0x80, 0x80}));
  EXPECT_EQ(pixel(canvas, 2, 6), (std::array{0x10, 0x20, 0x30}));
  EXPECT_EQ(pixel(canvas, 3, 2), (std::array{0x10, 0x20, 0x30}));
}

TEST(Canvas, AlphaLetsTheGroundThrough) {
  Canvas canvas(4, 4, kWhite);
  canvas.fill_rectangle({0.0, 0.0}, 4.0, 4.0, hex_colour(0xff0000, 0.25));
  EXPECT_EQ(pixel(canvas, 1, 1), (std::array{255, 191, 191}));
}

TEST(Canvas, DiscsHaveTheirEdgeAround) {
  Canvas canvas(40, 40, kWhite);
  canvas.disc({20.0, 20.0}, 8.0, hex_colour(0x00ff00), 2.0, kBlack);
  EXPECT_EQ(pixel(canvas, 20, 20), (std::array{0, 255, 0}));
  EXPECT_EQ(pixel(canvas, 20, 27), (std::array{0, 0, 0}));
  EXPECT_LT(pixel(canvas, 20, 28)[1], 20) << "the ring bends away within the pixel";
  EXPECT_EQ(pixel(canvas, 20, 30), (std::array{255, 255, 255}));
}

TEST(Canvas, TextIsAnchoredWhereItIsAsked) {
  const double width = text_width("HHH", 20.0);
  const auto columns = [&](double x_anchor) {
    Canvas canvas(200, 40, kWhite);
    canvas.text({100.0, 30.3}, "HHH", 20.0, kBlack, x_anchor);
    int left = 200;
    int right = 0;
    for (int column = 0; column < 200; ++column) {
      for (int row = 0; row < 40; ++row) {
        if (canvas.image().sample(row, column) > 200) continue;
        left = std::min(left, column);
        right = column;
      }
      EXPECT_EQ(canvas.image().sample(30, column), 255) << "below the base line";
    }
    return std::array{left, right};
  };
  EXPECT_NEAR(columns(0.0)[0], 100.0, 3.0);
  EXPECT_NEAR(columns(0.0)[1] + 1, 100.0 + width, 3.0);
  EXPECT_NEAR(columns(0.5)[0], 100.0 - 0.5 * width, 3.0);
  EXPECT_NEAR(columns(1.0)[1] + 1, 100.0, 3.0);
}

TEST(Canvas, AHaloStandsAroundLetters) {
  Canvas canvas(80, 40, hex_colour(0x808080));
  canvas.text_with_halo({10.0, 30.0}, "III", 24.0, kBlack, kWhite);
  int black = 0;
  int white = 0;
  for (int column = 0; column < 80; ++column) {
    black += canvas.image().sample(20, column) < 20 ? 1 : 0;
    white += canvas.image().sample(20, column) > 235 ? 1 : 0;
  }
  EXPECT_GE(black, 9);
  EXPECT_GE(white, 10);
}

TEST(Canvas, AClipHoldsUntilItEnds) {
  Canvas canvas(20, 20, kWhite);
  canvas.clip({5.0, 5.0}, 4.5, 4.0);
  canvas.fill_rectangle({-100.0, -100.0}, 300.0, 300.0, kBlack);
  EXPECT_NEAR(ink(canvas), 18.0, 0.05);
  canvas.clip({30.0, 30.0}, 4.0, -4.0);
  canvas.fill_rectangle({-100.0, -100.0}, 300.0, 300.0, kBlack);
  EXPECT_NEAR(ink(canvas), 18.0, 0.05);
  canvas.unclip();
  canvas.fill_rectangle({-100.0, -100.0}, 300.0, 300.0, kBlack);
  EXPECT_EQ(ink(canvas), 400.0);
}

TEST(Canvas, WhatLiesBeyondThePictureIsHarmless) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Canvas canvas(20, 20, kWhite);
  for (const Point& at : {Point{-1e9, 5.0}, Point{1e9, -1e9}, Point{5.0, 1e300}, Point{nan, 1.0}}) {
    canvas.disc(at, 5.0, kBlack, 1.0, kBlack);
    canvas.line({at, {at.x + 3.0, at.y}}, 2.0, kBlack);
    canvas.dashed_line({at, {at.x + 3.0, at.y}}, 2.0, kBlack, 1.0, 1.0);
    canvas.text_with_halo(at, "far away", 15.0, kBlack, kBlack);
    canvas.polygon({at, {at.x + 3.0, at.y}, {at.x, at.y + 3.0}}, kBlack, 1.0, kBlack);
  }
  EXPECT_EQ(ink(canvas), 0.0);
  canvas.dashed_line({{-1e9, 10.0}, {1e9, 10.0}}, 2.0, kBlack, 1.0, 1.0);
  EXPECT_NEAR(ink(canvas), 40.0, 0.5) << "a line across is drawn";
}

TEST(Canvas, PastesPixelsAndCutsAtAllEdges) {
  Image image = make_image(3, 2, 3);
  for (std::size_t i = 0; i < image.bytes.size(); ++i)
    image.bytes[i] = static_cast<std::uint8_t>(10 * i);
  Canvas canvas(4, 4, kWhite);
  canvas.paste(image, 1, 1);
  EXPECT_EQ(pixel(canvas, 1, 1), (std::array{0, 10, 20}));
  EXPECT_EQ(pixel(canvas, 2, 3), (std::array{150, 160, 170}));
  EXPECT_EQ(pixel(canvas, 3, 3), (std::array{255, 255, 255}));
  canvas.paste(image, -2, -1);
  EXPECT_EQ(pixel(canvas, 0, 0), (std::array{150, 160, 170}));
  canvas.paste(image, 3, 3);
  EXPECT_EQ(pixel(canvas, 3, 3), (std::array{0, 10, 20}));
  canvas.paste(image, 4, -7);
  EXPECT_THROW(Canvas(0, 4, kWhite), UsageError);
}

}  // namespace
}  // namespace loopstone
