#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

namespace loopstone {

/// How a number is stored in a binary file: 'f' floating point, 'i' signed, 'u' unsigned, and its
/// size.
struct ScalarType {
  char kind = 'f';
  int bytes = 4;  ///< 1, 2, 4, 8; 4 or 8 for 'f'

  [[nodiscard]] bool valid() const {
    const bool whole = kind == 'i' || kind == 'u';
    return bytes == 4 || bytes == 8 || (whole && (bytes == 1 || bytes == 2));
  }
};

/// Calls visit with a number of the type as it is in memory.
template <typename Visit>
void visit_scalar(ScalarType type, const Visit& visit) {
  if (type.kind == 'f') return type.bytes == 8 ? visit(double{}) : visit(float{});
  const bool is_signed = type.kind == 'i';
  if (type.bytes == 8) return is_signed ? visit(std::int64_t{}) : visit(std::uint64_t{});
  if (type.bytes == 4) return is_signed ? visit(std::int32_t{}) : visit(std::uint32_t{});
  if (type.bytes == 2) return is_signed ? visit(std::int16_t{}) : visit(std::uint16_t{});
  return is_signed ? visit(std::int8_t{}) : visit(std::uint8_t{});
}

/// Calls take(index, value) for each of `count` numbers, the first at `at`, the next `step` bytes
/// further. The type is asked once, not for each.
template <typename Take>
void load_scalars(ScalarType type, const char* at, std::size_t step, std::size_t count,
                  std::endian order, const Take& take) {
  visit_scalar(type, [&]<typename Number>(Number) {
    for (std::size_t i = 0; i < count; ++i, at += step) {
      std::array<char, sizeof(Number)> raw;
      std::memcpy(raw.data(), at, sizeof raw);
      if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
      take(i, static_cast<double>(std::bit_cast<Number>(raw)));
    }
  });
}

/// The number at `at`, whatever its alignment.
[[nodiscard]] inline double load_scalar(ScalarType type, const char* at, std::endian order) {
  const auto size = static_cast<std::size_t>(type.bytes);
  std::array<char, 8> raw{};
  std::memcpy(raw.data(), at, size);
  if (order != std::endian::native) {
    std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
  }
  const auto as = [&raw]<typename T>(T value) {
    std::memcpy(&value, raw.data(), sizeof value);
    return static_cast<double>(value);
  };
  switch (type.kind) {
    case 'f':
      return size == 8 ? as(0.0) : as(0.0F);
    case 'i':
      if (size == 8) return as(std::int64_t{});
      if (size == 4) return as(std::int32_t{});
      return size == 2 ? as(std::int16_t{}) : as(std::int8_t{});
    case 'u':
      if (size == 8) return as(std::uint64_t{});
      if (size == 4) return as(std::uint32_t{});
      return size == 2 ? as(std::uint16_t{}) : as(std::uint8_t{});
    default:
      return std::numeric_limits<double>::quiet_NaN();
  }
}

}  // namespace loopstone
