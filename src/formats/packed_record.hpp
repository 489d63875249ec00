#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace loopstone {

// Bytes as a database keeps them: packed by zstd, with a checksum of what they are unpacked.

[[nodiscard]] std::string pack_record(std::string_view bytes);

/// Throws std::runtime_error with the reason.
[[nodiscard]] std::string unpack_record(std::span<const char> packed);

}  // namespace loopstone
