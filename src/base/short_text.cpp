#include "loopstone/base/short_text.hpp"

#include <algorithm>

namespace loopstone {

namespace {

/// No number that means something is longer.
constexpr std::size_t kLongest = 40;
constexpr std::size_t kShown = 12;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

std::string with_short_numbers(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const bool digits = is_digit(text.front());
    const auto end =
        std::find_if(text.begin(), text.end(), [&](char c) { return is_digit(c) != digits; });
    const std::string_view run = text.substr(0, static_cast<std::size_t>(end - text.begin()));
    if (digits && run.size() > kLongest) {
      result.append(run.substr(0, kShown));
      result += "... (" + std::to_string(run.size()) + " digits)";
    } else {
      result.append(run);
    }
    text.remove_prefix(run.size());
  }
  return result;
}

}  // namespace loopstone
