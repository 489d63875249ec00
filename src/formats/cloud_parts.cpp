#include "formats/cloud_parts.hpp"

#include <algorithm>

#include "formats/text_lines.hpp"

namespace loopstone {

std::string show_word(std::string_view word) {
  std::string text = "'";
  for (const char c : word.substr(0, 40)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (word.size() > 40 ? "...'" : "'");
}

PointCloud finish_cloud(PointCloud cloud, bool has_z, const std::string& path) {
  const auto finite = [](const Eigen::Vector3d& point) { return point.allFinite(); };
  if (cloud.points.empty()) throw DataError({path}, "holds no points");
  if (std::none_of(cloud.points.begin(), cloud.points.end(), finite)) {
    throw DataError({path}, "holds no point that is finite");
  }
  cloud.planar =
      !has_z || std::all_of(cloud.points.begin(), cloud.points.end(), [](const auto& point) {
        return point.z() == 0.0 || !point.allFinite();
      });
  return cloud;
}

std::string_view HeadLines::next() {
  constexpr std::size_t kLongest = 1U << 16;
  const std::string_view rest = bytes_.substr(offset_);
  if (rest.empty()) {
    throw DataError({path_, line_ + 1}, "the file ends within its head: it was cut off");
  }
  ++line_;
  const std::size_t end = std::min(rest.find('\n'), rest.size());
  if (end > kLongest) fail("is no line of a head: it is longer than 64 KiB");
  offset_ += std::min(end + 1, rest.size());
  return trim(rest.substr(0, end));
}

}  // namespace loopstone
