#include "loopstone/formats/rgbd_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/sensor/camera_geometry.hpp"
#include "support/temp_dir.hpp"
#include "tiff_samples.hpp"

namespace loopstone {
namespace {

using testing::HasSubstr;

/// A camera with small pictures, so that tests are quick.
CameraModel small_camera() {
  CameraModel camera;
  camera.depth.width_px = 4;
  camera.depth.height_px = 3;
  camera.colour.width_px = 5;
  camera.colour.height_px = 2;
  return camera;
}

Image numbers_image(const std::vector<std::uint16_t>& numbers, int width) {
  Image image = make_image(width, static_cast<int>(numbers.size()) / width, 1, 2);
  std::memcpy(image.bytes.data(), numbers.data(), image.bytes.size());
  return image;
}

std::string pfm(const std::vector<float>& top_down, int width, std::endian order) {
  const auto columns = static_cast<std::size_t>(width);
  const std::size_t rows = top_down.size() / columns;
  std::string bytes = "Pf\n" + std::to_string(width) + " " + std::to_string(rows) +
                      (order == std::endian::little ? "\n-1.0\n" : "\n1\n");
  for (std::size_t row = rows; row-- > 0;) {
    for (std::size_t column = 0; column < columns; ++column) {
      const auto bits = std::bit_cast<std::uint32_t>(top_down[row * columns + column]);
      for (unsigned i = 0; i < 4; ++i) {
        const unsigned shift = 8 * (order == std::endian::little ? i : 3 - i);
        bytes += static_cast<char>((bits >> shift) & 0xffU);
      }
    }
  }
  return bytes;
}

template <typename Decode>
std::string error_of(const Decode& decode) {
  try {
    decode();
  } catch (const DataError& error) {
    return error.what();
  }
  return "no error";
}

InverseDepthImage decode(std::string_view bytes, const DepthEncoding& encoding = {}) {
  return decode_depth(bytes, encoding, inverse_depth_table(encoding), "d");
}

TEST(RgbdLoader, LoadsBothPicturesOfAFrame) {
  const test::TempDir folder;
  const std::vector<std::uint16_t> numbers{0, 1, 400, 700, 705, 2047, 65535, 500, 600, 650, 3, 0};
  write_png(folder / "d.png", numbers_image(numbers, 4));
  Image colour = make_image(5, 2, 3);
  for (std::size_t i = 0; i < colour.bytes.size(); ++i) {
    colour.bytes[i] = static_cast<std::uint8_t>(7 * i);
  }
  write_png(folder / "c.png", colour);

  const CameraModel camera = small_camera();
  const RgbdLoader loader(camera);
  const RgbdFrame frame{Stamp{5}, Stamp{7}, folder / "c.png", folder / "d.png"};
  const RgbdImages images = loader.load(frame);
  EXPECT_EQ(images.depth_stamp, Stamp{5});
  EXPECT_EQ(images.colour_stamp, Stamp{7});
  EXPECT_EQ(images.colour.rgb, colour.bytes);
  EXPECT_EQ(images.colour.at(4, 1)[2], colour.bytes.back());
  const std::vector<float> table = inverse_depth_table(camera.encoding);
  ASSERT_EQ(images.depth.per_m.size(), numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    EXPECT_EQ(images.depth.per_m[i], table[numbers[i]]) << i;
  }
  // The published formula: dd = -0.00304 d + 3.31, depth = 1.03 / dd.
  EXPECT_NEAR(images.depth.at(2, 0), (-0.00304 * 400 + 3.31) / 1.03, 1e-6);
  EXPECT_EQ(images.depth.at(0, 0), 0.0F);

  const RgbdImages only_depth = loader.load({Stamp{5}, Stamp{5}, {}, folder / "d.png"});
  EXPECT_TRUE(only_depth.colour.empty());
  EXPECT_FALSE(only_depth.depth.empty());
  const RgbdImages only_colour = loader.load({Stamp{5}, Stamp{5}, folder / "c.png", {}});
  EXPECT_TRUE(only_colour.depth.empty());
  EXPECT_FALSE(only_colour.colour.empty());
}

TEST(RgbdLoader, ManyThreadsLoadTheSameAsOne) {
  const test::TempDir folder;
  constexpr int kFrames = 8;
  Rng rng(6);
  std::vector<RgbdFrame> frames;
  for (int i = 0; i < kFrames; ++i) {
    const std::string number = std::to_string(i);
    std::vector<std::uint16_t> numbers(12);
    for (auto& value : numbers) value = static_cast<std::uint16_t>(300 + rng.below(700));
    write_png(folder / ("d" + number + ".png"), numbers_image(numbers, 4));
    Image colour = make_image(5, 2, 3);
    for (auto& byte : colour.bytes) byte = static_cast<std::uint8_t>(rng.below(256));
    write_png(folder / ("c" + number + ".png"), colour);
    frames.push_back(
        {Stamp{i}, Stamp{i}, folder / ("c" + number + ".png"), folder / ("d" + number + ".png")});
  }
  const RgbdLoader loader(small_camera());
  std::vector<RgbdImages> alone;
  for (const RgbdFrame& frame : frames) alone.push_back(RgbdLoader(small_camera()).load(frame));
  std::vector<int> different(4, 0);
  std::vector<std::thread> threads;
  for (std::size_t thread = 0; thread < different.size(); ++thread) {
    threads.emplace_back([&, thread] {
      for (std::size_t i = 0; i < 200; ++i) {
        const std::size_t frame = (i + 3 * thread) % kFrames;
        const RgbdImages images = loader.load(frames[frame]);
        if (images.colour.rgb != alone[frame].colour.rgb ||
            images.depth.per_m != alone[frame].depth.per_m) {
          ++different[thread];
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(different, std::vector<int>(4, 0));
}

TEST(RgbdLoader, AnotherSizeIsRefusedByName) {
  const test::TempDir folder;
  write_png(folder / "a.png", make_image(4, 3, 1, 2));
  write_png(folder / "b.png", make_image(640, 480, 3));
  CameraModel camera = small_camera();
  const auto error = [&](const std::string& colour, const std::string& depth) {
    return error_of([&] { (void)RgbdLoader(camera).load({Stamp{}, Stamp{}, colour, depth}); });
  };
  EXPECT_THAT(error(folder / "b.png", ""), HasSubstr("b.png"));
  EXPECT_THAT(error(folder / "b.png", ""), HasSubstr("is 640 x 480 pixels"));
  EXPECT_THAT(error(folder / "b.png", ""), HasSubstr("[camera.colour] says 5 x 2 pixels"));
  EXPECT_THAT(error(folder / "b.png", ""), HasSubstr("--robot"));
  camera.depth.width_px = 8;
  EXPECT_THAT(error("", folder / "a.png"), HasSubstr("[camera.depth] says 8 x 3 pixels"));
  camera.colour_is_registered = true;  // colour has the depth camera's pixels
  EXPECT_THAT(error(folder / "b.png", ""), HasSubstr("[camera.depth] says 8 x 3 pixels"));
  EXPECT_THAT(error(folder / "c.png", ""), HasSubstr("c.png"));
}

TEST(DecodeColour, EveryKindBecomesThreeChannelsOfEightBits) {
  Image grey = make_image(2, 1, 1);
  grey.bytes = {10, 200};
  EXPECT_EQ(decode_colour(encode_png(grey)).rgb,
            (std::vector<std::uint8_t>{10, 10, 10, 200, 200, 200}));
  Image grey_alpha = make_image(2, 1, 2);
  grey_alpha.bytes = {10, 0, 200, 255};
  EXPECT_EQ(decode_colour(encode_png(grey_alpha)).rgb,
            (std::vector<std::uint8_t>{10, 10, 10, 200, 200, 200}));
  Image rgba = make_image(1, 1, 4);
  rgba.bytes = {1, 2, 3, 0};
  EXPECT_EQ(decode_colour(encode_png(rgba)).rgb, (std::vector<std::uint8_t>{1, 2, 3}));
  Image wide = make_image(1, 1, 3, 2);
  const std::vector<std::uint16_t> samples{0, 257 * 100 + 128, 65535};
  std::memcpy(wide.bytes.data(), samples.data(), wide.bytes.size());
  EXPECT_EQ(decode_colour(encode_png(wide)).rgb, (std::vector<std::uint8_t>{0, 100, 255}));
  EXPECT_EQ(decode_colour("P3 1 1 15 0 5 15").rgb, (std::vector<std::uint8_t>{0, 85, 255}));
  EXPECT_EQ(decode_colour("P6 1 1 255\nabc").rgb, (std::vector<std::uint8_t>{'a', 'b', 'c'}));
}

TEST(DecodeDepth, MillimetresOf16Bits) {
  DepthEncoding encoding;
  encoding.kind = DepthKind::kDepth;
  encoding.range_min_m = 0.5;
  encoding.range_max_m = 8.0;
  const auto depth =
      decode(encode_png(numbers_image({0, 499, 500, 1000, 8000, 8001}, 3)), encoding);
  EXPECT_EQ(depth.width, 3);
  EXPECT_EQ(depth.height, 2);
  EXPECT_EQ(depth.per_m, (std::vector<float>{0.0F, 0.0F, 2.0F, 1.0F, 0.125F, 0.0F}));
}

TEST(DecodeDepth, MetresOfEveryFloatFormatAgree) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const std::vector<float> metres{0.0F, kNan,  kInfinity, -kInfinity, -1.0F, 0.39F,
                                  0.4F, 0.75F, 1.5F,      10.0F,      10.1F, 4.0F};
  std::vector<float> wanted;
  for (const float depth_m : metres) {
    wanted.push_back(depth_m >= 0.4F && depth_m <= 10.0F ? 1.0F / depth_m : 0.0F);
  }
  const auto check = [&](std::string_view bytes, const std::string& what) {
    const InverseDepthImage depth = decode(bytes);
    ASSERT_EQ(depth.width, 4) << what;
    ASSERT_EQ(depth.height, 3) << what;
    EXPECT_EQ(depth.per_m, wanted) << what;
  };
  check(pfm(metres, 4, std::endian::little), "little-endian PFM");
  check(pfm(metres, 4, std::endian::big), "big-endian PFM");
  for (const test::TiffLayout& layout : test::all_float_layouts()) {
    check(test::make_tiff(metres, 4, layout), "TIFF " + layout.text());
  }
}

TEST(DecodeDepth, NumbersOfEveryTiffAgree) {
  Rng rng(3);
  for (const test::TiffLayout& layout : test::all_number_layouts()) {
    const int width = 37;
    std::vector<std::uint16_t> numbers(37 * 41);
    for (auto& number : numbers) number = static_cast<std::uint16_t>(rng.below(1000));
    const InverseDepthImage png = decode(encode_png(numbers_image(numbers, width)));
    EXPECT_EQ(decode(test::make_tiff(numbers, width, layout)).per_m, png.per_m) << layout.text();
  }
}

TEST(DecodeDepth, LongLzwReachesTheWidestCodesAndStartsAnew) {
  Rng rng(4);
  std::vector<std::uint16_t> numbers(200 * 100);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    numbers[i] = static_cast<std::uint16_t>(i % 3000 < 1500 ? 600 : rng.below(65536));
  }
  test::TiffLayout layout;
  layout.packing = test::TiffSamplePacking::kLzw;
  layout.rows_per_strip = 100;
  EXPECT_EQ(decode(test::make_tiff(numbers, 200, layout)).per_m,
            decode(encode_png(numbers_image(numbers, 200))).per_m);
}

TEST(DecodeDepth, ChecksumsOfDeflateFindFlippedBits) {
  std::vector<std::uint16_t> numbers(16 * 8);
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<std::uint16_t>(7 * i);
  test::TiffLayout layout;
  layout.packing = test::TiffSamplePacking::kDeflate;
  layout.rows_per_strip = 8;
  const std::string good = test::make_tiff(numbers, 16, layout);
  const std::size_t packed =
      test::pack_tiff(test::encode_tiff_row(numbers, layout), test::TiffSamplePacking::kDeflate)
          .size();
  int taken = 0;
  for (std::size_t byte = 8; byte < 8 + packed; ++byte) {
    std::string damaged = good;
    damaged[byte] ^= 4;
    const std::string error = error_of([&] { (void)decode(damaged); });
    const bool is_taken = error == "no error";
    taken += is_taken ? 1 : 0;
    EXPECT_TRUE(is_taken || error.find("Deflate data is broken") != error.npos) << error;
  }
  // Where data that goes on wrongly takes the checksum for more data, there is none to ask.
  EXPECT_LE(taken, 2) << "of " << packed;
  EXPECT_GT(packed, 100U);
  // A last strip of all the rows that a strip has is longer than needed.
  layout.rows_per_strip = 6;
  std::vector<std::uint16_t> more = numbers;
  more.resize(16 * 12);
  const std::string twelve_rows = test::make_tiff(more, 16, layout);
  std::string eight_rows = twelve_rows;
  const std::size_t height = twelve_rows.rfind(std::string("\x01\x01\x04\0\1\0\0\0\x0c", 9));
  ASSERT_NE(height, std::string::npos);
  eight_rows[height + 8] = 8;
  EXPECT_EQ(decode(eight_rows).per_m, decode(good).per_m);
}

TEST(DecodeDepth, WhatCanNotBeDepthIsRefusedWithAWayOut) {
  const auto error = [](std::string_view bytes) { return error_of([&] { (void)decode(bytes); }); };
  EXPECT_THAT(error(encode_png(make_image(2, 2, 1, 1))), HasSubstr("1 channels of 8 bits"));
  EXPECT_THAT(error(encode_png(make_image(2, 2, 3, 2))), HasSubstr("3 channels of 16 bits"));
  EXPECT_THAT(error("PF\n2 2\n-1\n"), HasSubstr("three channels"));
  EXPECT_THAT(error("Pf\n2 2\n-0.5\n"), HasSubstr("scale"));
  EXPECT_THAT(error("Pf\n2 x\n-1\n"), HasSubstr("the height should be"));
  EXPECT_THAT(error("Pf\n2 2\n-1\nabc"), HasSubstr("need 16 bytes, 3 are left"));
  EXPECT_THAT(error("Pf"), HasSubstr("ends before the width"));
  EXPECT_THAT(error("Pf\n1000000 1000000\n-1\n"), HasSubstr("ends too early"));
  EXPECT_THAT(error(std::string_view("II+\0aaaaaaaa", 12)), HasSubstr("BigTIFF"));
  EXPECT_THAT(error(""), HasSubstr("empty"));
  EXPECT_THAT(error("hello"), HasSubstr("no picture"));
  EXPECT_THAT(error_of([] { (void)decode_colour(std::string_view("II*\0", 4), "c"); }),
              HasSubstr("convert"));
}

TEST(DecodeDepth, EveryTruncationAndManyFlipsAreRefusedOrRead) {
  const std::vector<float> metres{0.5F, 0.6F, 0.7F, 0.8F, 0.9F, 1.0F, 1.1F, 1.2F};
  std::vector<std::string> pictures{pfm(metres, 4, std::endian::little)};
  for (const test::TiffLayout& layout : test::all_float_layouts()) {
    pictures.push_back(test::make_tiff(metres, 4, layout));
  }
  Rng rng(5);
  const DepthEncoding encoding;
  const auto table = inverse_depth_table(encoding);
  for (const std::string& good : pictures) {
    int refused = 0;
    for (std::size_t length = 0; length < good.size(); ++length) {
      try {
        (void)decode_depth(std::string_view(good).substr(0, length), encoding, table);
      } catch (const DataError&) {
        ++refused;
      }
    }
    EXPECT_GE(refused, static_cast<int>(good.size()) - 8);  // the last bytes may be padding
    for (int i = 0; i < 300; ++i) {
      std::string damaged = good;
      damaged[rng.below(damaged.size())] ^= static_cast<char>(1U << rng.below(8));
      try {
        (void)decode_depth(damaged, encoding, table);
      } catch (const DataError&) {
        continue;
      }
    }
  }
}

}  // namespace
}  // namespace loopstone
