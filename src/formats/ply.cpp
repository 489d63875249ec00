#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <string>
#include <vector>

#include "formats/cloud_columns.hpp"
#include "formats/cloud_parts.hpp"
#include "formats/ply_head.hpp"
#include "formats/text_lines.hpp"
#include "formats/text_numbers.hpp"
#include "loopstone/formats/point_cloud_file.hpp"

namespace loopstone {
namespace {

/// Which property of the element is x, y and z.
struct Axes {
  std::array<std::optional<std::size_t>, 3> property{};

  [[nodiscard]] bool has_z() const { return property[2].has_value(); }
};

Axes find_axes(const PlyElement& vertex, const std::string& path) {
  Axes axes;
  for (std::size_t i = 0; i < vertex.properties.size(); ++i) {
    const PlyProperty& property = vertex.properties[i];
    if (property.list_size || property.name.size() != 1) continue;
    const int axis = property.name[0] - 'x';
    if (axis >= 0 && axis < 3) axes.property[static_cast<std::size_t>(axis)] = i;
  }
  if (!axes.property[0] || !axes.property[1]) {
    throw DataError({path}, "its element vertex has no properties x and y");
  }
  return axes;
}

/// Walks through binary values element by element.
class BinaryValues {
 public:
  BinaryValues(const PlyHead& head, std::string_view bytes, const std::string& path)
      : order_(head.data == PlyData::kBigEndian ? std::endian::big : std::endian::little),
        bytes_(bytes),
        at_(head.data_offset),
        path_(path) {}

  /// Refuses more elements than the bytes that are left can hold.
  void require_room(const PlyElement& element) const {
    const std::size_t least = element.least_bytes();
    const std::size_t left = bytes_.size() - at_;
    if (least == 0 || element.count <= left / least) return;
    fail(
        fmt::format("{} of element {} need at least {} bytes each and {} bytes are left: the file "
                    "was cut off, or its head is wrong",
                    element.count, show_word(element.name), least, left));
  }

  void skip(const PlyElement& element) {
    if (element.properties.empty()) return;
    require_room(element);
    if (!element.has_lists()) {
      at_ += element.count * element.least_bytes();
      return;
    }
    for (std::size_t i = 0; i < element.count; ++i) {
      for (const PlyProperty& property : element.properties) skip(property);
    }
  }

  [[nodiscard]] const char* here() const { return bytes_.data() + at_; }
  [[nodiscard]] std::endian order() const { return order_; }

  Eigen::Vector3d vertex(const PlyElement& element, const Axes& axes) {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      const auto axis = std::find(axes.property.begin(), axes.property.end(), i);
      if (axis == axes.property.end()) {
        skip(property);
      } else {
        point(axis - axes.property.begin()) = number(property.type);
      }
    }
    return point;
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    throw DataError({path_, {}, static_cast<std::int64_t>(at_)}, reason);
  }
  void require(std::size_t bytes) const {
    if (bytes > bytes_.size() - at_) fail("the file ends within an element: it was cut off");
  }
  double number(ScalarType type) {
    require(static_cast<std::size_t>(type.bytes));
    const double value = load_scalar(type, bytes_.data() + at_, order_);
    at_ += static_cast<std::size_t>(type.bytes);
    return value;
  }
  void skip(const PlyProperty& property) {
    std::size_t count = 1;
    if (property.list_size) {
      const double length = number(*property.list_size);
      if (length < 0.0) fail("a list has a negative length");
      count = static_cast<std::size_t>(length);
    }
    const auto size = static_cast<std::size_t>(property.type.bytes);
    require(saturated_product(count, size));
    at_ += count * size;
  }

  std::endian order_;
  std::string_view bytes_;
  std::size_t at_;
  const std::string& path_;
};

/// Of an element without lists, all of whose vertices are equally long.
std::array<std::optional<CloudColumn>, 3> columns_of(const PlyElement& element, const Axes& axes,
                                                     const char* begin) {
  std::array<std::optional<CloudColumn>, 3> columns;
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const ScalarType type = element.properties[i].type;
    const auto axis = std::find(axes.property.begin(), axes.property.end(), i);
    if (axis != axes.property.end()) {
      columns[static_cast<std::size_t>(axis - axes.property.begin())] =
          CloudColumn{begin, element.least_bytes(), type};
    }
    begin += type.bytes;
  }
  return columns;
}

PointCloud read_binary(const PlyHead& head, std::size_t vertex, const Axes& axes,
                       std::string_view bytes, const std::string& path) {
  BinaryValues values(head, bytes, path);
  for (std::size_t i = 0; i < vertex; ++i) values.skip(head.elements[i]);
  const PlyElement& element = head.elements[vertex];
  values.require_room(element);
  if (!element.has_lists()) {
    return read_columns(columns_of(element, axes, values.here()), element.count, values.order());
  }
  PointCloud cloud;
  cloud.points.reserve(element.count);
  for (std::size_t i = 0; i < element.count; ++i)
    cloud.points.push_back(values.vertex(element, axes));
  return cloud;
}

/// The coordinates on a line of text, stepping over lists.
Eigen::Vector3d parse_vertex(std::string_view line, const PlyElement& element, const Axes& axes,
                             const Location& where) {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Words words(line);
  const auto number = [&] {
    if (const auto short_number = words.next_short_number()) return *short_number;
    const std::string_view word = words.next();
    const auto value = parse_number(word);
    if (!value) {
      throw DataError(where, word.empty() ? "has fewer numbers than the head promises"
                                          : show_word(word) + " is no number");
    }
    return *value;
  };
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    if (element.properties[i].list_size) {
      for (double left = number(); left > 0.0; left -= 1.0) (void)number();
      continue;
    }
    const double value = number();
    const auto axis = std::find(axes.property.begin(), axes.property.end(), i);
    if (axis != axes.property.end()) point(axis - axes.property.begin()) = value;
  }
  return point;
}

bool is_empty(std::string_view line) {
  return line.empty() || (line.front() <= ' ' && trim(line).empty());
}

PointCloud read_ascii(const PlyHead& head, std::size_t vertex, const Axes& axes,
                      std::string_view text, const std::string& path) {
  std::size_t lines_before = 0;
  for (std::size_t i = 0; i < vertex; ++i) {
    if (!head.elements[i].properties.empty()) lines_before += head.elements[i].count;
  }
  const PlyElement& element = head.elements[vertex];
  PointCloud cloud;
  constexpr std::size_t kLeastLine = 4;  // "0 0\n"
  cloud.points.reserve(std::min(element.count, text.size() / kLeastLine + 1));
  std::size_t line_index = 0;
  for_each_line(text, [&](std::string_view line, std::int64_t number) {
    if (cloud.points.size() == element.count || is_empty(line)) return;
    if (line_index++ < lines_before) return;
    cloud.points.push_back(parse_vertex(line, element, axes, {path, head.head_lines + number}));
  });
  if (cloud.points.size() < element.count) {
    throw DataError({path},
                    fmt::format("holds {} of the {} vertices that its head promises: it was "
                                "cut off, or its head is wrong",
                                cloud.points.size(), element.count));
  }
  return cloud;
}

}  // namespace

PointCloud decode_ply(std::string_view bytes, const std::string& path, const MemoryBudget& budget) {
  const PlyHead head = parse_ply_head(bytes, path);
  const auto found =
      std::find_if(head.elements.begin(), head.elements.end(),
                   [](const PlyElement& element) { return element.name == "vertex"; });
  if (found == head.elements.end()) throw DataError({path}, "has no element vertex");
  const Axes axes = find_axes(*found, path);
  const auto vertex = static_cast<std::size_t>(found - head.elements.begin());
  // A vertex takes a byte at least, so a count beyond that is refused for what it is: a promise.
  require_points(std::min<std::uint64_t>(found->count, bytes.size()), 0, bytes.size(), budget,
                 {path});
  PointCloud cloud = head.data == PlyData::kAscii
                         ? read_ascii(head, vertex, axes, bytes.substr(head.data_offset), path)
                         : read_binary(head, vertex, axes, bytes, path);
  return finish_cloud(std::move(cloud), axes.has_z(), path);
}

}  // namespace loopstone
