#pragma once

#include <string_view>
#include <vector>

#include "report/outline.hpp"

// Text as shapes, in a font that is part of the program: DejaVu Sans.

namespace loopstone {

enum class FontWeight { kNormal, kBold };

/// Whether the font has every character of a text. Others, and bytes that are no UTF-8, are drawn
/// as a box.
[[nodiscard]] bool font_has(std::string_view words);
/// From the beginning of a text to where the next one would begin [px].
[[nodiscard]] double text_width(std::string_view words, double size_px,
                                FontWeight weight = FontWeight::kNormal);
/// \param at  the left end of the base line
[[nodiscard]] std::vector<Contour> text_outline(std::string_view words, Point at, double size_px,
                                                FontWeight weight = FontWeight::kNormal);

}  // namespace loopstone
