#pragma once

#include <string>
#include <string_view>

namespace loopstone {

/// For messages that quote a file: of a run of very many digits the first few, and how many there
/// are.
[[nodiscard]] std::string with_short_numbers(std::string_view text);

}  // namespace loopstone
