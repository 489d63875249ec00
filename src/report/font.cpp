#include "report/font.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/base/utf8.hpp"
#include "report/font_outlines.hpp"

namespace loopstone {
namespace {

constexpr double kUnitsPerEm = 2048.0;
constexpr double kFlatness = 0.03;  // [px] between a curve and the straight pieces drawn for it
/// More than any letter on a picture takes.
constexpr double kMostPieces = 64.0;

struct Face {
  std::span<const FontGlyph> glyphs;
  std::span<const std::int16_t> outlines;
};

Face face_of(FontWeight weight) {
  if (weight == FontWeight::kBold) return {kBoldGlyphs, kBoldOutlines};
  return {kRegularGlyphs, kRegularOutlines};
}

/// Takes the first character off a text that is not empty; 0 when it is no UTF-8.
char32_t take_character(std::string_view& text) {
  const std::size_t length = utf8_length(text);
  auto code = static_cast<char32_t>(static_cast<unsigned char>(text.front()));
  if (length > 1) code &= 0x7FU >> length;
  for (std::size_t i = 1; i < length; ++i)
    code = code << 6 | (static_cast<unsigned char>(text[i]) & 0x3FU);
  text.remove_prefix(std::max<std::size_t>(length, 1));
  return length == 0 ? 0 : code;
}

/// That of character 0 when there is none.
const FontGlyph& glyph_of(const Face& face, char32_t code) {
  const auto found = std::ranges::lower_bound(face.glyphs, code, {}, &FontGlyph::code);
  return found == face.glyphs.end() || found->code != code ? face.glyphs.front() : *found;
}

/// Adds the points of a parabola after its start.
void add_curve(Point start, Point control, Point end, Contour& to) {
  const double bend =
      hypotenuse(start.x - 2.0 * control.x + end.x, start.y - 2.0 * control.y + end.y);
  // A parabola in n pieces is off by a quarter of this over n^2.
  const bool is_straight = control.x == end.x && control.y == end.y;
  const double pieces_wanted = std::ceil(std::sqrt(0.25 * bend / kFlatness));
  int pieces = 1;
  // Far beyond the picture coordinates are too coarse for a bend to mean anything, or no numbers.
  if (!is_straight && pieces_wanted > 1.0)
    pieces = static_cast<int>(std::min(pieces_wanted, kMostPieces));
  for (int i = 1; i <= pieces; ++i) {
    const double t = static_cast<double>(i) / pieces;
    const double s = 1.0 - t;
    to.push_back({s * s * start.x + 2.0 * s * t * control.x + t * t * end.x,
                  s * s * start.y + 2.0 * s * t * control.y + t * t * end.y});
  }
}

void add_glyph(std::span<const std::int16_t> numbers, Point at, double scale,
               std::vector<Contour>& to) {
  const auto next = [&]() -> Point {
    const Point point{at.x + scale * numbers[0], at.y - scale * numbers[1]};
    numbers = numbers.subspan(2);
    return point;
  };
  while (!numbers.empty()) {
    const int curves = numbers[0];
    numbers = numbers.subspan(1);
    Contour& contour = to.emplace_back();
    contour.push_back(next());
    for (int i = 0; i < curves; ++i) {
      const Point control = next();
      const Point end = next();
      add_curve(contour.back(), control, end, contour);
    }
  }
}

}  // namespace

bool font_has(std::string_view words) {
  const Face face = face_of(FontWeight::kNormal);
  while (!words.empty()) {
    if (glyph_of(face, take_character(words)).code == 0) return false;
  }
  return true;
}

double text_width(std::string_view words, double size_px, FontWeight weight) {
  const Face face = face_of(weight);
  std::int64_t units = 0;
  while (!words.empty()) units += glyph_of(face, take_character(words)).advance;
  return static_cast<double>(units) * size_px / kUnitsPerEm;
}

std::vector<Contour> text_outline(std::string_view words, Point at, double size_px,
                                  FontWeight weight) {
  const Face face = face_of(weight);
  const double scale = size_px / kUnitsPerEm;
  std::vector<Contour> found;
  std::int64_t units = 0;
  while (!words.empty()) {
    const FontGlyph& glyph = glyph_of(face, take_character(words));
    add_glyph(face.outlines.subspan(static_cast<std::size_t>(glyph.first),
                                    static_cast<std::size_t>(glyph.count)),
              {at.x + static_cast<double>(units) * scale, at.y}, scale, found);
    units += glyph.advance;
  }
  return found;
}

}  // namespace loopstone
