#include "loopstone/formats/tum.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "formats/atomic_file.hpp"
#include "formats/text_lines.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/decimal_stamp.hpp"
#include "loopstone/geometry/pose3.hpp"

namespace loopstone {
namespace {

/// Nothing prints as -0.000000000.
double without_negative_zero(double value) { return std::abs(value) < 5e-10 ? 0.0 : value; }

StampedPose2 parse_pose(std::string_view line, const Location& location) {
  const std::vector<std::string_view> words = split_words(line);
  if (words.size() != 8) {
    throw DataError(
        location, fmt::format("expected 8 numbers (t x y z qx qy qz qw), found {}", words.size()));
  }
  const std::optional<Stamp> stamp = parse_decimal_stamp(words[0]);
  if (!stamp) throw DataError(location, "the first word is no time in seconds");
  std::array<double, 7> v{};
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = parse_finite(words[i + 1], location);
  const Eigen::Quaterniond rotation(v[6], v[3], v[4], v[5]);
  if (std::abs(rotation.norm() - 1.0) > 0.01) {
    throw DataError(location, fmt::format("the quaternion has length {:.3g}; expected 1 (columns "
                                          "are t x y z qx qy qz qw)",
                                          rotation.norm()));
  }
  return {*stamp, project_to_plane(Pose3{{v[0], v[1], v[2]}, rotation.normalized()})};
}

}  // namespace

std::string format_tum(const Trajectory& trajectory) {
  std::string text;
  text.reserve(trajectory.size() * 110);
  for (const auto& [stamp, pose] : trajectory.poses()) {
    // yaw is in (-pi, pi], so cos(yaw / 2) >= 0: the sign that readers can rely on.
    const double qw = std::abs(std::cos(0.5 * pose.yaw));
    fmt::format_to(std::back_inserter(text), "{} {:.9f} {:.9f} 0 0 0 {:.9f} {:.9f}\n",
                   format_decimal_stamp(stamp), without_negative_zero(pose.x),
                   without_negative_zero(pose.y), without_negative_zero(std::sin(0.5 * pose.yaw)),
                   qw);
  }
  return text;
}

Trajectory parse_tum(std::string_view text, const std::string& path_for_errors) {
  std::vector<StampedPose2> poses;
  for_each_line(text, [&](std::string_view line, std::int64_t number) {
    const std::string_view content = trim(line);
    if (content.empty() || content.front() == '#') return;
    poses.push_back(parse_pose(content, {path_for_errors, number}));
  });
  if (poses.empty())
    throw DataError({path_for_errors}, "holds no poses; expected lines of t x y z qx qy qz qw");
  return Trajectory(std::move(poses));
}

void write_tum(const std::string& path, const Trajectory& trajectory) {
  write_file_atomically(path, format_tum(trajectory));
}

Trajectory read_tum(const std::string& path, const MemoryBudget& budget) {
  return parse_tum(read_whole_file(path, budget.most_text_bytes()), path);
}

}  // namespace loopstone
