#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/scalar_type.hpp"

namespace loopstone {

enum class PlyData { kAscii, kLittleEndian, kBigEndian };

struct PlyProperty {
  std::string name{};
  ScalarType type{};                      ///< of the value, or of a list's elements
  std::optional<ScalarType> list_size{};  ///< present: a list, and how its length is stored
};

struct PlyElement {
  std::string name{};
  std::size_t count = 0;
  std::vector<PlyProperty> properties{};

  [[nodiscard]] bool has_lists() const;
  /// Bytes of one, when it has no lists; the least number of bytes when it has.
  [[nodiscard]] std::size_t least_bytes() const;
};

/// What stands before the values of a .ply file (Turk 1994, "The PLY polygon file format").
struct PlyHead {
  PlyData data = PlyData::kAscii;
  std::vector<PlyElement> elements{};
  std::size_t data_offset = 0;  ///< in the file
  std::int64_t head_lines = 0;
};

/// Throws DataError with the line. Counts are not checked against the file.
[[nodiscard]] PlyHead parse_ply_head(std::string_view bytes, const std::string& path);

}  // namespace loopstone
