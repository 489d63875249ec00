#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "loopstone/base/error.hpp"

namespace loopstone {

/// Calls visit(line, number) for every line, numbers from 1, line ends ("\n", "\r\n") taken off.
void for_each_line(std::string_view text,
                   const std::function<void(std::string_view, std::int64_t)>& visit);

/// Without blanks, tabs and carriage returns at both ends.
[[nodiscard]] std::string_view trim(std::string_view text);

/// The words between blanks and tabs.
[[nodiscard]] std::vector<std::string_view> split_words(std::string_view line);
/// The same into a vector whose memory is kept from line to line.
void split_words(std::string_view line, std::vector<std::string_view>& words);

/// What stands between commas, trimmed; an empty line is one empty cell.
[[nodiscard]] std::vector<std::string_view> split_cells(std::string_view line);

/// A finite number that fills the whole word; otherwise DataError at the location.
[[nodiscard]] double parse_finite(std::string_view word, const Location& location);

}  // namespace loopstone
