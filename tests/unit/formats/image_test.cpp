#include "loopstone/formats/image.hpp"

#include <gtest/gtest.h>

#include <string>

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
  has(error_of("hello"), "PGM (P2, P5) or PNG");
  has(error_of("P1 1 1 1"), "P2 or P5");
  has(error_of("P5"), "m (byte 2): the width");
  has(error_of("P5 2 2 255"), "(byte 10): the header does not end");
  has(error_of("P5 2 2 255\nabc"), "ends too early");
  has(error_of("P5 0 2 255\nabc"), "must not be 0");
  has(error_of("P5 -1 2 255\nabc"), "the width");
  has(error_of("P5 2 2 65536\nabc"), "the largest value");
  has(error_of("P5 1000000 1000000 255\n"), "2^28");
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
