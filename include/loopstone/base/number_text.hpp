#pragma once

#include <array>
#include <charconv>
#include <string>

namespace loopstone {

/// A number for people, with so many digits at most, as %g writes it: "0.05", "4e+09". However
/// large it is, it stays short.
[[nodiscard]] inline std::string number_text(double value, int digits = 6) {
  std::array<char, 40> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::general, digits);
  return {text.data(), end.ptr};
}

}  // namespace loopstone
