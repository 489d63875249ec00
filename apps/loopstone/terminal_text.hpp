#pragma once

#include <string>
#include <string_view>

namespace loopstone::app {

/// A text as a terminal may get it: control characters, which could move the cursor, change titles
/// or answer for the user, and bytes that are not UTF-8 are written out as "\\x1b"; line ends and
/// tabs stay. For texts that may quote a log or a path.
[[nodiscard]] std::string terminal_text(std::string_view text);

/// A JSON or TOML document as a terminal may get it: both let DEL and the control characters from
/// U+0080 to U+009F stand in texts, here they become "\\u007f". What it says stays the same.
[[nodiscard]] std::string with_escaped_controls(std::string_view document);

}  // namespace loopstone::app
