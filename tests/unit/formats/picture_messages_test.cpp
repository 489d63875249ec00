// Pictures as messages hold them.

#include "formats/picture_messages.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "jpeg_samples.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/image.hpp"

namespace loopstone {
namespace {

constexpr int kWidth = 6;
constexpr int kHeight = 4;

/// A colour for each pixel, none like another.
std::array<std::uint8_t, 3> colour_at(int column, int row) {
  return {static_cast<std::uint8_t>(10 + 20 * column), static_cast<std::uint8_t>(5 + 60 * row),
          static_cast<std::uint8_t>(200 - 9 * column - 30 * row)};
}

/// Rows end with some bytes of no meaning.
template <typename Put>
msg::Image picture(const std::string& encoding, int pixel_bytes, const Put& put) {
  msg::Image image{.height = kHeight,
                   .width = kWidth,
                   .encoding = encoding,
                   .step = static_cast<std::uint32_t>(kWidth * pixel_bytes + 5)};
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) put(column, row, image.data);
    image.data.insert(image.data.end(), 5, 0xEE);
  }
  return image;
}

std::string refusal(const msg::Image& image) {
  try {
    (void)to_colour(image, "here");
  } catch (const DataError& error) {
    return error.what();
  }
  return "nothing";
}

struct Samples {
  const char* encoding;
  std::vector<int> order;  ///< of red 0, green 1, blue 2, and 9: anything
  int bytes = 1;
  bool is_bigendian = false;
};

class EachColourEncoding : public testing::TestWithParam<Samples> {};

TEST_P(EachColourEncoding, GivesTheColours) {
  const Samples& samples = GetParam();
  const auto put = [&](int column, int row, std::vector<std::uint8_t>& data) {
    for (const int channel : samples.order) {
      const std::uint8_t value =
          channel == 9 ? 0x77 : colour_at(column, row)[static_cast<std::size_t>(channel)];
      if (samples.bytes == 1) {
        data.push_back(value);
      } else if (samples.is_bigendian) {
        data.insert(data.end(), {value, 0x33});
      } else {
        data.insert(data.end(), {0x33, value});
      }
    }
  };
  msg::Image message =
      picture(samples.encoding, static_cast<int>(samples.order.size()) * samples.bytes, put);
  message.is_bigendian = samples.is_bigendian ? 1 : 0;
  EXPECT_EQ(content_of(samples.encoding), PictureContent::kColour);
  const ColourImage colour = to_colour(message, "here");
  ASSERT_EQ(colour.width, kWidth);
  ASSERT_EQ(colour.height, kHeight);
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const std::uint8_t* const seen = colour.at(column, row);
      EXPECT_EQ((std::array{seen[0], seen[1], seen[2]}), colour_at(column, row));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(PictureMessages, EachColourEncoding,
                         testing::Values(Samples{"rgb8", {0, 1, 2}}, Samples{"bgr8", {2, 1, 0}},
                                         Samples{"rgba8", {0, 1, 2, 9}},
                                         Samples{"bgra8", {2, 1, 0, 9}}, Samples{"8UC3", {2, 1, 0}},
                                         Samples{"rgb16", {0, 1, 2}, 2},
                                         Samples{"bgr16", {2, 1, 0}, 2, true}));

TEST(PictureMessages, GreyIsExpanded) {
  const msg::Image message =
      picture("mono8", 1, [](int column, int row, std::vector<std::uint8_t>& data) {
        data.push_back(static_cast<std::uint8_t>(10 * row + column));
      });
  const ColourImage colour = to_colour(message, "here");
  for (const int channel : {0, 1, 2}) EXPECT_EQ(colour.at(4, 3)[channel], 34);
}

TEST(PictureMessages, PairsShareTheirColour) {
  // Red, whose brightness is 76 of 255 and whose colour is (-43, 127).
  struct Case {
    const char* encoding;
    std::array<std::uint8_t, 4> pair;
  };
  for (const auto& [encoding, pair] :
       {Case{"yuv422_yuy2", {76, 85, 76, 255}}, Case{"yuv422", {85, 76, 255, 76}}}) {
    const auto bytes = pair;
    const msg::Image message =
        picture(encoding, 2, [&](int column, int /*row*/, std::vector<std::uint8_t>& data) {
          const auto at = static_cast<std::size_t>(column % 2 * 2);
          data.insert(data.end(), {bytes[at], bytes[at + 1]});
        });
    const ColourImage colour = to_colour(message, "here");
    for (const int column : {0, 1, 5}) {
      EXPECT_NEAR(colour.at(column, 2)[0], 254, 1) << encoding;
      EXPECT_NEAR(colour.at(column, 2)[1], 0, 1) << encoding;
      EXPECT_NEAR(colour.at(column, 2)[2], 0, 1) << encoding;
    }
  }
}

TEST(PictureMessages, MosaicsAreFilledIn) {
  // Of one colour all over: every pixel must get it, whatever its own filter.
  struct Case {
    const char* encoding;
    int red_column, red_row;
  };
  for (const auto& [encoding, red_column, red_row] :
       {Case{"bayer_rggb8", 0, 0}, Case{"bayer_grbg8", 1, 0}, Case{"bayer_gbrg8", 0, 1},
        Case{"bayer_bggr8", 1, 1}}) {
    const int at_column = red_column;
    const int at_row = red_row;
    const msg::Image message =
        picture(encoding, 1, [&](int column, int row, std::vector<std::uint8_t>& data) {
          const bool in_column = column % 2 == at_column;
          const bool in_row = row % 2 == at_row;
          data.push_back(in_column && in_row ? 210 : in_column || in_row ? 120 : 30);
        });
    const ColourImage colour = to_colour(message, "here");
    for (std::size_t i = 0; i < colour.rgb.size(); i += 3) {
      EXPECT_EQ((std::array{colour.rgb[i], colour.rgb[i + 1], colour.rgb[i + 2]}),
                (std::array<std::uint8_t, 3>{210, 120, 30}))
          << encoding << " " << i / 3;
    }
  }
}

TEST(PictureMessages, WhatIsMissingIsSaid) {
  const auto put = [](int, int, std::vector<std::uint8_t>& data) { data.insert(data.end(), 3, 1); };
  const msg::Image good = picture("rgb8", 3, put);
  msg::Image cut = good;
  cut.data.resize(cut.data.size() - 6);  // one byte more than the end of the last row
  EXPECT_NE(refusal(cut).find("bytes of pixels"), std::string::npos) << refusal(cut);
  msg::Image narrow = good;
  narrow.step = 17;
  EXPECT_NE(refusal(narrow).find("rows of 17 bytes"), std::string::npos) << refusal(narrow);
  msg::Image huge = good;
  huge.height = std::numeric_limits<std::uint32_t>::max();
  EXPECT_NE(refusal(huge).find("can't be used"), std::string::npos) << refusal(huge);
  msg::Image unknown = good;
  unknown.encoding = "jolly8";
  EXPECT_NE(refusal(unknown).find("'jolly8'"), std::string::npos) << refusal(unknown);
  EXPECT_EQ(content_of("jolly8"), PictureContent::kUnknown);
}

// Depth.

msg::Image depth_picture(const std::vector<std::uint16_t>& numbers, bool is_bigendian) {
  msg::Image message{.height = 1,
                     .width = static_cast<std::uint32_t>(numbers.size()),
                     .encoding = "16UC1",
                     .is_bigendian = is_bigendian,
                     .step = static_cast<std::uint32_t>(2 * numbers.size())};
  for (const std::uint16_t number : numbers) {
    const auto low = static_cast<std::uint8_t>(number & 0xFFU);
    const auto high = static_cast<std::uint8_t>(number >> 8U);
    const auto first = is_bigendian ? high : low;
    message.data.insert(message.data.end(), {first, is_bigendian ? low : high});
  }
  return message;
}

void expect_depths(const InverseDepthImage& depth, const std::vector<double>& depths_m) {
  ASSERT_EQ(depth.per_m.size(), depths_m.size());
  for (std::size_t i = 0; i < depths_m.size(); ++i) {
    const double expected = depths_m[i] > 0.0 ? 1.0 / depths_m[i] : 0.0;
    EXPECT_NEAR(depth.per_m[i], expected, 1e-4 * expected) << i;
  }
}

TEST(PictureMessages, DepthInMillimetres) {
  const std::vector<std::uint16_t> numbers{0, 399, 400, 1234, 10000, 10001};
  const DepthEncoding disparities{};  // what numbers mean in a recording is not that
  for (const bool is_bigendian : {false, true}) {
    expect_depths(to_depth(depth_picture(numbers, is_bigendian), disparities, "here"),
                  {0, 0, 0.4, 1.234, 10.0, 0});
  }
  const DepthEncoding finer{.kind = DepthKind::kDepth, .metres_per_unit = 0.0002};
  expect_depths(to_depth(depth_picture({5000}, false), finer, "here"), {1.0});
}

TEST(PictureMessages, DepthInMetres) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  constexpr float kFar = std::numeric_limits<float>::infinity();
  msg::Image message{.height = 2, .width = 3, .encoding = "32FC1", .step = 12};
  for (const float depth_m : {1.5F, kNone, 0.0F, -2.0F, kFar, 9.5F}) {
    const auto bytes = std::bit_cast<std::array<std::uint8_t, 4>>(depth_m);
    message.data.insert(message.data.end(), bytes.begin(), bytes.end());
  }
  expect_depths(to_depth(message, {}, "here"), {1.5, 0, 0, 0, 0, 9.5});
}

msg::CompressedImage packed(const std::string& format, const std::string& bytes) {
  msg::CompressedImage message{.format = format};
  message.data.assign(bytes.begin(), bytes.end());
  return message;
}

std::string png_of(const std::vector<std::uint16_t>& numbers) {
  Image image{.width = static_cast<int>(numbers.size()),
              .height = 1,
              .channels = 1,
              .bytes_per_sample = 2,
              .max_value = 65535};
  image.bytes.resize(2 * numbers.size());
  std::memcpy(image.bytes.data(), numbers.data(), image.bytes.size());
  return encode_png(image);
}

TEST(PictureMessages, CompressedDepth) {
  const std::string head(12, '\0');
  const DepthEncoding encoding{};
  expect_depths(
      to_depth(packed("16UC1; compressedDepth png", head + png_of({0, 2500})), encoding, "here"),
      {0, 2.5});
  expect_depths(to_depth(packed("16UC1; png compressed", png_of({0, 2500})), encoding, "here"),
                {0, 2.5});
  // Depth in metres is stored as numerator / depth + offset.
  const float numerator = 1001.0F;
  const float offset = 1.0F;
  std::string quantised_head = head;
  std::memcpy(quantised_head.data() + 4, &numerator, 4);
  std::memcpy(quantised_head.data() + 8, &offset, 4);
  expect_depths(to_depth(packed("32FC1; compressedDepth png", quantised_head + png_of({0, 501})),
                         encoding, "here"),
                {0, 2.002});
  EXPECT_THROW((void)to_depth(packed("16UC1; compressedDepth png", "short"), encoding, "here"),
               DataError);
}

TEST(PictureMessages, TellsWhatPicturesShow) {
  EXPECT_EQ(content_of("16UC1"), PictureContent::kDepth);
  EXPECT_EQ(content_of("16UC1; compressedDepth"), PictureContent::kDepth);
  EXPECT_EQ(content_of("mono16"), PictureContent::kGrey16);
  EXPECT_EQ(content_of("bgr8; jpeg compressed bgr8"), PictureContent::kColour);
  EXPECT_EQ(content_of("png"), PictureContent::kColour);
  EXPECT_EQ(content_of("16UC1; compressedDepth rvl"), PictureContent::kUnknown);
  EXPECT_EQ(content_of("h264"), PictureContent::kUnknown);
}

// JPEG.

TEST(PictureMessages, JpegOfEveryKind) {
  for (const std::string& bytes : {test::jpeg_baseline(), test::jpeg_progressive()}) {
    const ColourImage colour = to_colour(packed("jpeg", bytes), "here");
    ASSERT_EQ(colour.width, 32);
    ASSERT_EQ(colour.height, 16);
    const auto expect_near = [&](int column, int row, std::array<int, 3> expected) {
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(colour.at(column, row)[c], expected[c], 2);
    };
    expect_near(3, 3, {200, 40, 30});
    expect_near(28, 12, {20, 90, 180});
  }
  const ColourImage grey = to_colour(packed("mono8; jpeg compressed", test::jpeg_grey()), "here");
  EXPECT_NEAR(grey.at(3, 3)[0], 87, 2);
  EXPECT_EQ(grey.at(3, 3)[0], grey.at(3, 3)[2]);
}

TEST(PictureMessages, JpegThatIsCutIsRefused) {
  for (const std::string& bytes : {test::jpeg_baseline(), test::jpeg_progressive()}) {
    for (std::size_t size = 0; size + 4 < bytes.size(); size += 7) {
      EXPECT_THROW((void)decode_image(bytes.substr(0, size), "here"), DataError) << size;
    }
    EXPECT_NO_THROW((void)decode_image(bytes + std::string(64, '\0'), "here"));
  }
}

TEST(PictureMessages, JpegThatClaimsTooMuchIsRefused) {
  std::string bytes = test::jpeg_baseline();
  const std::size_t frame = bytes.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  for (const std::size_t i : {5, 6, 7, 8}) bytes[frame + i] = '\xfa';  // height and width
  MemoryBudget small;
  small.ceiling_bytes = std::uint64_t{1} << 24;
  EXPECT_THROW((void)decode_image(bytes, "here", small), DataError);
}

}  // namespace
}  // namespace loopstone
