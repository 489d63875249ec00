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

/// \param escaped  what stands for a control character, or for a byte that is no UTF-8 (`is_utf8`
///                 false)
template <typename Escaped>
std::string without_controls(std::string_view text, Escaped&& escaped) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const std::string_view character = text.substr(0, length == 0 ? 1 : length);
    if (length > 0 && !is_control(character)) {
      result += character;
    } else {
      result += escaped(character, length > 0);
    }
    text.remove_prefix(character.size());
  }
  return result;
}

}  // namespace

std::string terminal_text(std::string_view text) {
  return without_controls(text, [](std::string_view character, bool /*is_utf8*/) {
    std::string bytes;
    for (const char byte : character)
      bytes += fmt::format("\\x{:02x}", static_cast<unsigned char>(byte));
    return bytes;
  });
}

std::string with_escaped_controls(std::string_view document) {
  return without_controls(document, [](std::string_view character, bool is_utf8) {
    // The last byte of U+0080 to U+009F is the character's number.
    return is_utf8 ? fmt::format("\\u{:04x}", static_cast<unsigned char>(character.back()))
                   : std::string(character);
  });
}

}  // namespace loopstone::app
