#pragma once

namespace loopstone {

constexpr int kLetterColumns = 5;
constexpr int kLetterRows = 7;

/// Whether a letter's dot is inked; row 0 at the top. A to Z, 0 to 9, full stop, hyphen; everything
/// else is blank.
[[nodiscard]] bool is_inked(char letter, int column, int row);

}  // namespace loopstone
