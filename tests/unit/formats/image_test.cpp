#include "loopstone/formats/image.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/png_plain.hpp"
#include "formats/png_unfilter.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using namespace std::string_literals;

Image random_image(std::uint64_t seed, int width, int height, int channels, int bytes_per_sample) {
  Rng rng(seed);
  Image image = make_image(width, height, channels, bytes_per_sample);
  for (auto& byte : image.bytes) byte = static_cast<std::uint8_t>(rng.below(256));
  return image;
}

std::string error_of(std::string_view bytes) {
  try {
    (void)decode_image(bytes, "m");
  } catch (const DataError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Png, RoundTripOfEveryKind) {
  for (int channels = 1; channels <= 4; ++channels) {
    for (const int bytes_per_sample : {1, 2}) {
      const Image image = random_image(7, 37, 23, channels, bytes_per_sample);
      for (const int compression : {0, 1, 9}) {
        const Image back = decode_png(encode_png(image, compression));
        ASSERT_EQ(back.width, image.width);
        ASSERT_EQ(back.height, image.height);
        ASSERT_EQ(back.channels, channels);
        ASSERT_EQ(back.bytes_per_sample, bytes_per_sample);
        ASSERT_EQ(back.bytes, image.bytes);
      }
    }
  }
}

TEST(Png, EveryTruncationAndManyFlipsAreRefusedOrRead) {
  const std::string good = encode_png(random_image(8, 16, 16, 3, 1), 6);
  for (std::size_t length = 0; length < good.size(); ++length) {
    EXPECT_THROW((void)decode_image(std::string_view(good).substr(0, length)), DataError) << length;
  }
  Rng rng(9);
  for (int i = 0; i < 2000; ++i) {
    std::string damaged = good;
    damaged[rng.below(damaged.size())] ^= static_cast<char>(1U << rng.below(8));
    try {
      (void)decode_image(damaged);
    } catch (const DataError&) {
      continue;
    }
  }
}

/// The naive twin of the quick decoder is libpng.
TEST(Png, TheQuickDecoderAgreesWithLibpng) {
  Rng rng(12);
  for (int channels = 1; channels <= 4; ++channels) {
    for (const int bytes_per_sample : {1, 2}) {
      // Smooth pictures, so that libpng chooses every filter somewhere.
      Image image = make_image(61, 47, channels, bytes_per_sample);
      for (std::size_t i = 0; i < image.bytes.size(); ++i) {
        image.bytes[i] = static_cast<std::uint8_t>(i / 3 + rng.below(3 + i / 4000));
      }
      for (const int compression : {0, 1, 6, 9}) {
        const std::string bytes = encode_png(image, compression);
        const auto quick = decode_plain_png(bytes);
        ASSERT_TRUE(quick) << channels << " channels";
        const Image slow = decode_any_png(bytes, "m");
        EXPECT_EQ(quick->bytes, slow.bytes);
        EXPECT_EQ(quick->width, slow.width);
        EXPECT_EQ(quick->channels, slow.channels);
        EXPECT_EQ(quick->bytes_per_sample, slow.bytes_per_sample);
        EXPECT_EQ(quick->max_value, slow.max_value);
      }
    }
  }
}

TEST(Png, EveryFilterIsUndone) {
  // Bytes that no encoder would choose, with each filter on a row; libpng tells what they mean.
  Rng rng(13);
  for (const std::size_t bytes_per_pixel : {1U, 2U, 3U, 4U, 6U, 8U}) {
    const std::size_t row_bytes = 9 * bytes_per_pixel;
    std::vector<std::uint8_t> rows;
    for (int row = 0; row < 40; ++row) {
      rows.push_back(static_cast<std::uint8_t>(rng.below(5)));
      for (std::size_t i = 0; i < row_bytes; ++i) {
        rows.push_back(static_cast<std::uint8_t>(rng.below(256)));
      }
    }
    std::vector<std::uint8_t> wanted = rows;
    for (std::size_t row = 0; row < 40; ++row) {
      std::uint8_t* const at = &wanted[row * (row_bytes + 1)];
      for (std::size_t i = 1; i <= row_bytes; ++i) {
        const bool has_left = i > bytes_per_pixel;
        const int a = has_left ? at[i - bytes_per_pixel] : 0;
        const int b = row > 0 ? (at - row_bytes - 1)[i] : 0;
        const int c = row > 0 && has_left ? (at - row_bytes - 1)[i - bytes_per_pixel] : 0;
        const int p = a + b - c;  // PNG specification, section 9.4
        const int pa = std::abs(p - a);
        const int pb = std::abs(p - b);
        const int pc = std::abs(p - c);
        const int paeth = pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
        const std::array<int, 5> guess{0, a, b, (a + b) / 2, paeth};
        at[i] = static_cast<std::uint8_t>(at[i] + guess[at[0]]);
      }
    }
    ASSERT_TRUE(unfilter_png(rows.data(), row_bytes, 40, bytes_per_pixel));
    EXPECT_EQ(rows, wanted) << bytes_per_pixel;
    rows[0] = 5;
    EXPECT_FALSE(unfilter_png(rows.data(), row_bytes, 40, bytes_per_pixel));
  }
}

TEST(Png, WhatTheQuickDecoderTakesLibpngTakesToo) {
  const std::string good = encode_png(random_image(8, 16, 16, 3, 1), 6);
  Rng rng(10);
  int taken = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string damaged = good;
    for (std::uint64_t flips = rng.below(3); flips > 0; --flips) {
      damaged[rng.below(damaged.size())] ^= static_cast<char>(1U << rng.below(8));
    }
    const auto quick = decode_plain_png(damaged);
    if (!quick) continue;
    ++taken;
    EXPECT_EQ(decode_any_png(damaged, "m").bytes, quick->bytes);
  }
  EXPECT_GT(taken, 500);
  EXPECT_FALSE(decode_plain_png(good.substr(0, good.size() - 1)));
}

TEST(Png, RowsAreWrittenOneAtATime) {
  const test::TempDir dir;
  for (int channels = 1; channels <= 4; ++channels) {
    const Image image = random_image(14, 33, 21, channels, 1);
    int calls = 0;
    write_png_rows(dir / "a.png", 33, 21, channels, [&](int row, std::span<std::uint8_t> samples) {
      EXPECT_EQ(row, calls++);
      const std::size_t stride = samples.size();
      std::copy_n(image.bytes.begin() + static_cast<std::ptrdiff_t>(stride) * row, stride,
                  samples.begin());
    });
    const Image back = read_image(dir / "a.png");
    EXPECT_EQ(back.bytes, image.bytes);
    EXPECT_EQ(back.channels, channels);
  }
  const auto fails = [](int row, std::span<std::uint8_t>) {
    if (row == 5) throw DataError({"frames"}, "ended");
  };
  EXPECT_THROW(write_png_rows(dir / "b.png", 9, 9, 3, fails), DataError);
  EXPECT_FALSE(std::filesystem::exists(dir / "b.png"));
  EXPECT_THROW(write_png_rows(dir / "b.png", 0, 9, 3, fails), UsageError);
  EXPECT_THROW(write_png_rows(dir / "b.png", 9, 9, 5, fails), UsageError);
}

TEST(Pgm, PlainAndRawWithComments) {
  const Image plain =
      decode_pnm("P2 # made by hand\n# 3 x 2\n3 2\n# most\n15\n0 5 15\n#row\n1 2 3");
  EXPECT_EQ(plain.width, 3);
  EXPECT_EQ(plain.max_value, 15);
  EXPECT_EQ(plain.sample(0, 2), 15);
  EXPECT_EQ(plain.sample(1, 0), 1);
  const Image raw = decode_pnm("P5\n# CREATOR: a tool\n2 2\n255\n\x00\x7f\xcd\xff"s);
  EXPECT_EQ(raw.sample(0, 1), 127);
  EXPECT_EQ(raw.sample(1, 0), 205);
  const Image wide = decode_pnm("P5 2 1 65535\n\x01\x02\xff\xfe"s);
  EXPECT_EQ(wide.bytes_per_sample, 2);
  EXPECT_EQ(wide.sample(0, 0), 258);
  EXPECT_EQ(wide.sample(0, 1), 65534);
  EXPECT_EQ(decode_pnm("P6 1 1 255\nabc").sample(0, 0, 2), 'c');
  EXPECT_EQ(decode_pnm("P3 1 1 9 1 2 3").channels, 3);
  // A raw pixel that looks like white space or a comment belongs to the picture.
  EXPECT_EQ(decode_pnm("P5 2 1 255\n\n#").sample(0, 0), '\n');
}

TEST(Pgm, RoundTrip) {
  const Image image = random_image(10, 31, 17, 1, 1);
  EXPECT_EQ(decode_pnm(encode_pgm(image)).bytes, image.bytes);
  EXPECT_THROW((void)encode_pgm(random_image(10, 3, 3, 3, 1)), UsageError);
}

TEST(Pgm, DamageIsNamedWithItsPlace) {
  const auto has = [](const std::string& error, const char* part) {
    EXPECT_NE(error.find(part), std::string::npos) << error;
  };
  has(error_of(""), "is empty");
  has(error_of("hello"), "PGM (P2, P5), PNG or JPEG");
  has(error_of("P1 1 1 1"), "P2 or P5");
  has(error_of("P5"), "m (byte 2): the width");
  has(error_of("P5 2 2 255"), "(byte 10): the header does not end");
  has(error_of("P5 2 2 255\nabc"), "ends too early");
  has(error_of("P5 0 2 255\nabc"), "must not be 0");
  has(error_of("P5 -1 2 255\nabc"), "the width");
  has(error_of("P5 2 2 65536\nabc"), "the largest value");
  has(error_of("P5 1000000 1000000 255\n"), "ends too early");
  has(error_of("P5 10000 10000 255\n"), "need at least 100000000 bytes");
  has(error_of("P2 2 1 10\n3 11"), "a pixel");
  has(error_of("P2 2 1 10\n3 x"), "a pixel");
  has(error_of("P5 99999999999999999999 1 255\n"), "the width");
}

TEST(Image, SidesMustBePositiveAndSane) {
  EXPECT_THROW((void)make_image(0, 5, 1), UsageError);
  EXPECT_THROW((void)make_image(1 << 20, 1 << 20, 4), UsageError);
}

TEST(Image, FileRoundTrip) {
  const test::TempDir dir;
  const Image image = random_image(11, 5, 4, 3, 1);
  write_png(dir / "a.png", image);
  EXPECT_EQ(read_image(dir / "a.png").bytes, image.bytes);
  EXPECT_THROW((void)read_image(dir / "b.png"), DataError);
}

}  // namespace
}  // namespace loopstone
