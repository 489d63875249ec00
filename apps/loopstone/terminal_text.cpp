#include "terminal_text.hpp"

#include <fmt/format.h>

#include "loopstone/base/utf8.hpp"

namespace loopstone::app {

namespace {

/// ESC and its like, DEL, and U+0080 to U+009F, in which some terminals see them, too.
bool is_control(std::string_view character) {
  const auto first = static_cast<unsigned char>(character[0]);
  if (first == '\n' || first == '\t') return false;
  if (character.size() == 1) return first < 0x20 || first == 0x7F;
  return first == 0xC2 && static_cast<unsigned char>(character[1]) < 0xA0;
}

}  // namespace

std::string terminal_text(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const std::string_view character = text.substr(0, length == 0 ? 1 : length);
    if (length > 0 && !is_control(character)) {
      result += character;
    } else {
      for (const char byte : character)
        result += fmt::format("\\x{:02x}", static_cast<unsigned char>(byte));
    }
    text.remove_prefix(character.size());
  }
  return result;
}

std::string with_escaped_controls(std::string_view document) {
  std::string escaped;
  escaped.reserve(document.size());
  for (std::size_t i = 0; i < document.size(); ++i) {
    const auto byte = static_cast<unsigned char>(document[i]);
    const auto next = static_cast<unsigned char>(i + 1 < document.size() ? document[i + 1] : 0);
    if (byte == 0x7f) {
      escaped += "\\u007f";
    } else if (byte == 0xc2 && next >= 0x80 && next <= 0x9f) {
      escaped += fmt::format("\\u{:04x}", next);
      ++i;
    } else {
      escaped += document[i];
    }
  }
  return escaped;
}

}  // namespace loopstone::app
