#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/scalar_type.hpp"

namespace loopstone {

enum class PcdData { kAscii, kBinary, kBinaryCompressed };

struct PcdField {
  std::string name{};
  ScalarType type{};
  std::size_t count = 1;
  std::size_t byte_offset = 0;  ///< of its first element within a point
  std::size_t word_offset = 0;  ///< the same in words of an ascii line

  [[nodiscard]] std::size_t size() const { return count * static_cast<std::size_t>(type.bytes); }
};

/// What stands before the points of a .pcd file (pointclouds.org, "The PCD file format").
struct PcdHead {
  std::vector<PcdField> fields{};
  std::size_t points = 0;
  PcdData data = PcdData::kAscii;
  std::size_t point_bytes = 0;
  std::size_t point_words = 0;
  std::size_t data_offset = 0;  ///< in the file
  std::int64_t head_lines = 0;
  std::array<std::optional<PcdField>, 3> xyz{};  ///< z may be missing
};

/// Throws DataError with the line. Sizes are checked to be possible at all, not against the file.
[[nodiscard]] PcdHead parse_pcd_head(std::string_view bytes, const std::string& path);

}  // namespace loopstone
