#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace loopstone {

/// Unpacks what LibLZF packed. Nothing when the packed bytes are damaged or do not make exactly
/// `size` bytes. Memory grows with what the packed bytes can make, not with `size`.
[[nodiscard]] std::optional<std::string> lzf_decompress(std::string_view packed, std::size_t size);

}  // namespace loopstone
