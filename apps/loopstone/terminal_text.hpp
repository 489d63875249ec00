#pragma once

#include <string>
#include <string_view>

namespace loopstone::app {

/// A text as a terminal may get it: control characters, which could move the cursor, change titles or answer for the user, and
/// bytes that are not UTF-8 are written out as "\\x1b"; line ends and tabs stay. For texts that may quote a log or a path.
[[nodiscard]] std::string terminal_text(std::string_view text);

}  // namespace loopstone::app
