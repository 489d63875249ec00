#pragma once

#include <zlib.h>

#include <cstdint>
#include <string_view>

namespace loopstone {

/// Of `before`'s bytes and these. Source: ISO 3309; the one of zlib and PNG.
[[nodiscard]] inline std::uint32_t crc32_of(std::string_view bytes, std::uint32_t before = 0) {
  if (bytes.empty()) return before;  // zlib takes no bytes for a question after the first value
  return static_cast<std::uint32_t>(
      ::crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace loopstone
