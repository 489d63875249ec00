#pragma once

#include <cstddef>
#include <string_view>

namespace loopstone {

/// Length of the valid UTF-8 character at the beginning of a text that is not empty, 0 when there
/// is none (RFC 3629, table 3-7 of Unicode).
[[nodiscard]] std::size_t utf8_length(std::string_view text);

}  // namespace loopstone
