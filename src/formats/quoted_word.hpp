#pragma once

#include <string>
#include <string_view>

namespace loopstone {

/// A word of a file for a message, in quotes; of a long one the beginning.
[[nodiscard]] inline std::string quoted(std::string_view word) {
  constexpr std::size_t kMost = 40;
  const bool is_long = word.size() > kMost;
  return "'" + std::string(word.substr(0, kMost)) + (is_long ? "...'" : "'");
}

}  // namespace loopstone
