#pragma once

#include <bit>
#include <concepts>
#include <cstring>

namespace loopstone {

static_assert(std::endian::native == std::endian::little, "recordings are little-endian");

/// A number as it stands in a file, at any place in memory.
template <std::unsigned_integral T>
[[nodiscard]] inline T little_endian(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

}  // namespace loopstone
