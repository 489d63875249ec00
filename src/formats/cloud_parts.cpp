#include "formats/cloud_parts.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "formats/text_lines.hpp"

namespace loopstone {

std::string show_word(std::string_view word) {
  std::string text = "'";
  for (const char c : word.substr(0, 40)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (word.size() > 40 ? "...'" : "'");
}

namespace {

double farthest_coordinate(const Eigen::Vector3d& point) {
  Eigen::Index axis = 0;
  (void)point.cwiseAbs().maxCoeff(&axis);
  return point(axis);
}

/// A number that stands for a missing point (3.4e38) would pull the whole cloud apart.
void refuse_far_points(const PointCloud& cloud, const std::string& path) {
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Eigen::Vector3d& point = cloud.points[i];
    if (!point.allFinite() || is_usable_point(point)) continue;
    throw DataError(
        {path}, fmt::format("point {} has a coordinate of {:.4g}: more than {:g} m is no place; "
                            "if it stands for a missing point, write nan",
                            i + 1, farthest_coordinate(point), kFarthestCoordinateM));
  }
}

}  // namespace

void require_points(std::uint64_t points, std::uint64_t held_bytes, std::uint64_t file_bytes,
                    const MemoryBudget& budget, const Location& where) {
  const std::uint64_t bytes = saturated_product(points, sizeof(Eigen::Vector3d));
  budget.require(std::max(bytes, bytes + held_bytes), file_bytes, Growth::kNumbers, where);
}

PointCloud finish_cloud(PointCloud cloud, bool has_z, const std::string& path) {
  refuse_far_points(cloud, path);
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
