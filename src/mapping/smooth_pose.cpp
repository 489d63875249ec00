#include "mapping/smooth_pose.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <vector>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

constexpr double kMostStep_s = 0.25;  ///< poses farther apart say nothing of each other's motion

/// The cubic at t in [t1, t2] through values at t1 and t2 with the slopes that the values at t0 and
/// t3 suggest.
double cubic(const std::array<double, 4>& t, const std::array<double, 4>& value, double at) {
  const double step = t[2] - t[1];
  const auto slope = [&](std::size_t i) {
    // Of the parabola through three neighbours.
    const double before = (value[i] - value[i - 1]) / (t[i] - t[i - 1]);
    const double after = (value[i + 1] - value[i]) / (t[i + 1] - t[i]);
    const double share = (t[i] - t[i - 1]) / (t[i + 1] - t[i - 1]);
    return (1.0 - share) * before + share * after;
  };
  const double s = (at - t[1]) / step;
  const double s2 = s * s;
  const double s3 = s2 * s;
  return (2.0 * s3 - 3.0 * s2 + 1.0) * value[1] + (s3 - 2.0 * s2 + s) * step * slope(1) +
         (3.0 * s2 - 2.0 * s3) * value[2] + (s3 - s2) * step * slope(2);
}

}  // namespace

std::optional<Pose2> smooth_pose_at(const Trajectory& trajectory, Stamp stamp) {
  const std::vector<StampedPose2>& poses = trajectory.poses();
  const auto after =
      std::upper_bound(poses.begin(), poses.end(), stamp,
                       [](Stamp wanted, const StampedPose2& pose) { return wanted < pose.stamp; });
  const auto index = static_cast<std::size_t>(std::distance(poses.begin(), after));
  if (index < 2 || index + 1 >= poses.size()) return trajectory.at(stamp);
  std::array<double, 4> t{};
  std::array<double, 4> x{};
  std::array<double, 4> y{};
  std::array<double, 4> yaw{};
  const StampedPose2& base = poses[index - 1];
  for (std::size_t i = 0; i < 4; ++i) {
    const StampedPose2& pose = poses[index - 2 + i];
    t[i] = (pose.stamp - base.stamp).seconds();
    if (i > 0 && t[i] - t[i - 1] > kMostStep_s) return trajectory.at(stamp);
    x[i] = pose.pose.x;
    y[i] = pose.pose.y;
    yaw[i] = base.pose.yaw + wrap_angle(pose.pose.yaw - base.pose.yaw);
  }
  const double at = (stamp - base.stamp).seconds();
  return Pose2{cubic(t, x, at), cubic(t, y, at), wrap_angle(cubic(t, yaw, at))};
}

}  // namespace loopstone
