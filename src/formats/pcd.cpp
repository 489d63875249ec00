#include <fmt/format.h>

#include <array>
#include <bit>
#include <string>
#include <vector>

#include "formats/cloud_columns.hpp"
#include "formats/cloud_parts.hpp"
#include "formats/lzf.hpp"
#include "formats/pcd_head.hpp"
#include "formats/text_lines.hpp"
#include "formats/text_numbers.hpp"
#include "loopstone/formats/point_cloud_file.hpp"

namespace loopstone {
namespace {

/// Refuses a promise of more points than the bytes that are there can hold.
void require_room(const PcdHead& head, std::size_t bytes, std::size_t bytes_per_point,
                  const std::string& path) {
  if (bytes_per_point == 0 || head.points <= bytes / bytes_per_point) return;
  throw DataError({path, {}, static_cast<std::int64_t>(head.data_offset + bytes)},
                  fmt::format("the file ends after {} bytes of points; {} points take at least {} "
                              "each: it was cut off, or POINTS is wrong",
                              bytes, head.points, bytes_per_point));
}

PointCloud read_ascii(const PcdHead& head, std::string_view text, const std::string& path,
                      const MemoryBudget& budget) {
  require_room(head, text.size() + 1, 2 * head.point_words, path);
  require_points(head.points, 0, text.size(), budget, {path});
  PointCloud cloud;
  cloud.points.reserve(head.points);
  std::vector<std::string_view> words;
  for_each_line(text, [&](std::string_view line, std::int64_t number) {
    if (cloud.points.size() == head.points) return;
    split_words(line, words);
    if (words.empty() || words[0].starts_with('#')) return;
    const Location where{path, head.head_lines + number};
    if (words.size() < head.point_words) {
      throw DataError(
          where, fmt::format("has {} numbers, a point has {}", words.size(), head.point_words));
    }
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!head.xyz[axis]) continue;
      const std::string_view word = words[head.xyz[axis]->word_offset];
      const auto value = parse_number(word);
      if (!value) throw DataError(where, show_word(word) + " is no number");
      point(static_cast<Eigen::Index>(axis)) = *value;
    }
    cloud.points.push_back(point);
  });
  if (cloud.points.size() < head.points) {
    throw DataError({path}, fmt::format("holds {} of the {} points that its head promises: it was "
                                        "cut off, or POINTS is wrong",
                                        cloud.points.size(), head.points));
  }
  return cloud;
}

PointCloud read_binary(const PcdHead& head, std::string_view bytes, const std::string& path,
                       const MemoryBudget& budget) {
  require_room(head, bytes.size(), head.point_bytes, path);
  require_points(head.points, 0, bytes.size(), budget, {path});
  std::array<std::optional<CloudColumn>, 3> columns;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (const auto& field = head.xyz[axis]) {
      columns[axis] = CloudColumn{bytes.data() + field->byte_offset, head.point_bytes, field->type};
    }
  }
  return read_columns(columns, head.points, std::endian::little);
}

/// Two sizes, then the packed bytes; unpacked, all values of the first field stand first, then
/// those of the second.
PointCloud read_compressed(const PcdHead& head, std::string_view bytes, const std::string& path,
                           const MemoryBudget& budget) {
  const Location where{path, {}, static_cast<std::int64_t>(head.data_offset)};
  if (bytes.size() < 8) throw DataError(where, "the sizes of the packed points are cut off");
  constexpr ScalarType kSize{'u', 4};
  const auto packed_size =
      static_cast<std::size_t>(load_scalar(kSize, bytes.data(), std::endian::little));
  const auto size =
      static_cast<std::size_t>(load_scalar(kSize, bytes.data() + 4, std::endian::little));
  bytes.remove_prefix(8);
  if (packed_size > bytes.size()) {
    throw DataError(where, fmt::format("the packed points take {} bytes and {} are there: the file "
                                       "was cut off",
                                       packed_size, bytes.size()));
  }
  if (head.point_bytes == 0 || head.points > size / head.point_bytes ||
      head.points * head.point_bytes != size) {
    throw DataError(where,
                    fmt::format("the packed points make {} bytes; {} points of {} bytes were "
                                "expected",
                                size, head.points, head.point_bytes));
  }
  require_points(head.points, size, bytes.size(), budget, {path});
  const auto unpacked = lzf_decompress(bytes.substr(0, packed_size), size);
  if (!unpacked) throw DataError(where, "the packed points are damaged");
  std::array<std::optional<CloudColumn>, 3> columns;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (const auto& field = head.xyz[axis]) {
      columns[axis] = CloudColumn{unpacked->data() + field->byte_offset * head.points,
                                  field->size(), field->type};
    }
  }
  return read_columns(columns, head.points, std::endian::little);
}

}  // namespace

PointCloud decode_pcd(std::string_view bytes, const std::string& path, const MemoryBudget& budget) {
  const PcdHead head = parse_pcd_head(bytes, path);
  const std::string_view data = bytes.substr(head.data_offset);
  const auto read = head.data == PcdData::kAscii    ? read_ascii
                    : head.data == PcdData::kBinary ? read_binary
                                                    : read_compressed;
  return finish_cloud(read(head, data, path, budget), head.xyz[2].has_value(), path);
}

}  // namespace loopstone
