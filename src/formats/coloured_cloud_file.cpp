#include "loopstone/formats/coloured_cloud_file.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstddef>
#include <cstring>
#include <string_view>

#include "formats/atomic_file.hpp"

namespace loopstone {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they stand");

/// Always of the same length: a comment makes up for the digits of the count, which is known at the end.
std::string head_for(std::int64_t points) {
  constexpr std::size_t kMostDigits = 20;
  const std::string count = std::to_string(points);
  return fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment written by loopstone, metres, sRGB{}\n"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
      std::string(kMostDigits - count.size(), ' '), count);
}

}  // namespace

struct ColouredCloudFile::File {
  explicit File(const std::string& path) : atomic(path) {}
  AtomicFile atomic;
};

ColouredCloudFile::ColouredCloudFile(const std::string& path)
    : file_(std::make_unique<File>(path)) {
  file_->atomic.write(head_for(0));
}

ColouredCloudFile::~ColouredCloudFile() = default;

void ColouredCloudFile::add(const Eigen::Vector3f& point_m,
                            const std::array<std::uint8_t, 3>& rgb) {
  constexpr std::size_t kCoordinates = 3 * sizeof(float);
  std::array<char, kCoordinates + 3> record{};
  std::memcpy(record.data(), point_m.data(), kCoordinates);
  std::memcpy(record.data() + kCoordinates, rgb.data(), rgb.size());
  file_->atomic.write(std::string_view(record.data(), record.size()));
  ++points_;
}

void ColouredCloudFile::commit() {
  file_->atomic.replace_front(head_for(points_));
  file_->atomic.commit();
}

}  // namespace loopstone
