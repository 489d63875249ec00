#pragma once

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/quoted_word.hpp"
#include "formats/text_lines.hpp"
#include "formats/text_numbers.hpp"
#include "loopstone/base/stamp.hpp"

// Lines of MRCLAM's files.

namespace loopstone {

[[nodiscard]] inline std::string_view without_comment(std::string_view line) {
  return trim(line.substr(0, line.find('#')));
}

/// A line of a time and numbers, or why it is none.
template <std::size_t kCount>
struct TimedLine {
  Stamp stamp{};
  std::array<double, kCount> values{};
  std::string fault{};
};

template <std::size_t kCount>
[[nodiscard]] TimedLine<kCount> timed_line(std::string_view content, const char* expected) {
  TimedLine<kCount> line;
  const std::vector<std::string_view> words = split_words(content);
  if (words.size() != kCount + 1) {
    line.fault =
        fmt::format("expected {} values ({}), found {}", kCount + 1, expected, words.size());
    return line;
  }
  const auto stamp = parse_stamp(words[0]);
  if (!stamp) {
    line.fault = quoted(words[0]) + " is no time in seconds";
    return line;
  }
  line.stamp = *stamp;
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto value = parse_number(words[i + 1]);
    if (!value || !std::isfinite(*value)) {
      line.fault = quoted(words[i + 1]) + " is no finite number";
      return line;
    }
    line.values[i] = *value;
  }
  return line;
}

/// A whole number; nothing when it is none, or too large for an id.
[[nodiscard]] inline std::optional<int> whole(double value) {
  if (value != std::floor(value) || std::abs(value) > 1e9) return std::nullopt;
  return static_cast<int>(value);
}

}  // namespace loopstone
