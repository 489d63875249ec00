#include "loopstone/formats/coloured_cloud_file.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstddef>

namespace loopstone {

static_assert(std::endian::native == std::endian::little, "numbers are written as they stand");

std::string encode_coloured_cloud(std::span<const ColouredPoint> points) {
  std::string text = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment written by loopstone, metres, sRGB\n"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
      points.size());
  constexpr std::size_t kCoordinates = 3 * sizeof(float);
  text.reserve(text.size() + (kCoordinates + 3) * points.size());
  for (const ColouredPoint& point : points) {
    text.append(reinterpret_cast<const char*>(point.position_m.data()), kCoordinates);
    text.append(reinterpret_cast<const char*>(point.rgb.data()), point.rgb.size());
  }
  return text;
}

}  // namespace loopstone
