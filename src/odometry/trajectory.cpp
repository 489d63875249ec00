#include "loopstone/odometry/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "loopstone/base/hypotenuse.hpp"

namespace loopstone {

namespace {

bool earlier(const StampedPose2& pose, Stamp stamp) { return pose.stamp < stamp; }

}  // namespace

Trajectory::Trajectory(std::vector<StampedPose2> poses) {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const StampedPose2& a, const StampedPose2& b) { return a.stamp < b.stamp; });
  poses_.reserve(poses.size());
  for (const auto& pose : poses) append(pose.stamp, pose.pose);
}

bool Trajectory::append(Stamp stamp, const Pose2& pose) {
  if (!poses_.empty() && stamp < poses_.back().stamp) return false;
  if (!poses_.empty() && stamp == poses_.back().stamp) {
    poses_.back().pose = pose;
    return true;
  }
  poses_.push_back({stamp, pose});
  return true;
}

std::optional<Pose2> Trajectory::at(Stamp stamp) const {
  if (poses_.empty() || stamp < poses_.front().stamp || stamp > poses_.back().stamp) return {};
  const auto after = std::lower_bound(poses_.begin(), poses_.end(), stamp, earlier);
  if (after->stamp == stamp) return after->pose;
  const auto before = std::prev(after);
  const double ratio = (stamp - before->stamp).seconds() / (after->stamp - before->stamp).seconds();
  return interpolate(before->pose, after->pose, ratio);
}

std::optional<Pose2> Trajectory::at_clamped(Stamp stamp) const {
  if (poses_.empty()) return {};
  if (stamp <= poses_.front().stamp) return poses_.front().pose;
  if (stamp >= poses_.back().stamp) return poses_.back().pose;
  return at(stamp);
}

std::optional<Pose2> Trajectory::nearest(Stamp stamp, Duration tolerance) const {
  if (poses_.empty()) return {};
  auto best = std::lower_bound(poses_.begin(), poses_.end(), stamp, earlier);
  if (best == poses_.end() ||
      (best != poses_.begin() && stamp - std::prev(best)->stamp <= best->stamp - stamp)) {
    best = std::prev(best);
  }
  const Duration distance{std::abs((best->stamp - stamp).nanoseconds)};
  if (distance > tolerance) return {};
  return best->pose;
}

double Trajectory::path_length_m() const {
  double length = 0.0;
  for (std::size_t i = 1; i < poses_.size(); ++i) {
    length += hypotenuse(poses_[i].pose.x - poses_[i - 1].pose.x,
                         poses_[i].pose.y - poses_[i - 1].pose.y);
  }
  return length;
}

}  // namespace loopstone
