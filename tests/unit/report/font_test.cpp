#include "report/font.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "loopstone/base/utf8.hpp"
#include "report/font_outlines.hpp"
#include "source_folder.hpp"

namespace loopstone {
namespace {

struct Extent {
  double left = 1e9;
  double right = -1e9;
  double top = 1e9;
  double bottom = -1e9;
};

Extent extent_of(const std::vector<Contour>& contours) {
  Extent extent;
  for (const Contour& contour : contours) {
    for (const Point& point : contour) {
      extent.left = std::min(extent.left, point.x);
      extent.right = std::max(extent.right, point.x);
      extent.top = std::min(extent.top, point.y);
      extent.bottom = std::max(extent.bottom, point.y);
    }
  }
  return extent;
}

std::string utf8(char32_t code) {
  const auto tail = [&](int shift) { return static_cast<char>(0x80 | (code >> shift & 0x3F)); };
  if (code < 0x80) return {static_cast<char>(code)};
  if (code < 0x800) return {static_cast<char>(0xC0 | code >> 6), tail(0)};
  return {static_cast<char>(0xE0 | code >> 12), tail(6), tail(0)};
}

TEST(Font, HasAsciiAndLatinInBothWeights) {
  for (char32_t code = 0x20; code < 0x100; ++code) {
    if (code >= 0x7F && code < 0xA0) continue;
    EXPECT_TRUE(font_has(utf8(code))) << static_cast<unsigned>(code);
  }
  EXPECT_TRUE(
      std::ranges::equal(kRegularGlyphs, kBoldGlyphs, {}, &FontGlyph::code, &FontGlyph::code));
  EXPECT_TRUE(std::ranges::is_sorted(kRegularGlyphs, {}, &FontGlyph::code));
  EXPECT_TRUE(font_has("5 mm ± 2 µm, 3°, 4 m², 1–2 σ, ≥ 7 ×"));
}

// Whatever a source of pictures says, in any literal.
TEST(Font, HasEveryCharacterThatPicturesSay) {
  int sources = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(LOOPSTONE_SOURCE_DIR "/src/report")) {
    std::ifstream file(entry.path());
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    if (entry.path().extension() != ".cpp" || text.find("anvas") == std::string::npos) continue;
    ++sources;
    for (std::size_t i = 0; i < text.size();) {
      const std::size_t length =
          std::max<std::size_t>(utf8_length(std::string_view(text).substr(i)), 1);
      const std::string character = text.substr(i, length);
      if (character != "\n") {
        EXPECT_TRUE(font_has(character)) << entry.path() << ": " << character;
      }
      i += length;
    }
  }
  EXPECT_GE(sources, 8);
}

TEST(Font, WhatIsMissingIsABox) {
  EXPECT_FALSE(font_has("a\u65e5b"));
  EXPECT_FALSE(font_has("a\xff"));
  const auto box = text_outline("\u65e5", {0.0, 0.0}, 20.0);
  ASSERT_EQ(box.size(), 2U);
  EXPECT_EQ(extent_of(text_outline("\xff", {0.0, 0.0}, 20.0)).right, extent_of(box).right);
  EXPECT_GT(text_width("\u65e5", 20.0), 5.0);
}

TEST(Font, WidthsAddUpAndGrowWithTheSize) {
  const double whole = text_width("Loop closures", 15.0);
  EXPECT_NEAR(whole, text_width("Loop", 15.0) + text_width(" closures", 15.0), 1e-9);
  EXPECT_NEAR(text_width("Loop closures", 30.0), 2.0 * whole, 1e-9);
  EXPECT_GT(text_width("Loop closures", 15.0, FontWeight::kBold), whole);
  EXPECT_EQ(text_width("", 15.0), 0.0);
}

TEST(Font, OutlinesFillTheWidthThatIsMeasured) {
  for (const FontWeight weight : {FontWeight::kNormal, FontWeight::kBold}) {
    for (const char* words : {"Hamburg 1234567890", "start", "12.5 m²", "path, 0 s"}) {
      const Extent extent = extent_of(text_outline(words, {100.0, 50.0}, 20.0, weight));
      const double width = text_width(words, 20.0, weight);
      EXPECT_NEAR(extent.left, 100.0, 2.5) << words;
      EXPECT_NEAR(extent.right, 100.0 + width, 2.5) << words;
    }
  }
}

TEST(Font, LettersStandOnTheBaseLine) {
  const Extent capital = extent_of(text_outline("H", {0.0, 50.0}, 20.0));
  EXPECT_DOUBLE_EQ(capital.bottom, 50.0);
  EXPECT_NEAR(capital.top, 50.0 - 20.0 * 1493.0 / 2048.0, 1e-9);
  EXPECT_GT(extent_of(text_outline("g", {0.0, 50.0}, 20.0)).bottom, 53.0);
  EXPECT_TRUE(text_outline("  ", {0.0, 50.0}, 20.0).empty());
}

}  // namespace
}  // namespace loopstone
