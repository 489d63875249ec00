#include "loopstone/slam/map_result.hpp"

#include <algorithm>

namespace loopstone {

Eigen::Matrix3d MapResult::covariance_at(Stamp stamp) const {
  const auto later = std::ranges::lower_bound(node_stamps, stamp);
  const auto node = [&](auto at) { return NodeId{static_cast<int>(at - node_stamps.begin())}; };
  if (later == node_stamps.begin()) return covariances.of(node(later));
  if (later == node_stamps.end()) return covariances.of(node(later - 1));
  const auto earlier = later - 1;
  const double share = (stamp - *earlier).seconds() / (*later - *earlier).seconds();
  return (1.0 - share) * covariances.of(node(earlier)) + share * covariances.of(node(later));
}

std::vector<Trajectory> MapResult::trajectories() const {
  std::vector<Trajectory> all(drives.size() + 1);
  std::size_t drive = 0;
  for (const StampedPose2& pose : trajectory.poses()) {
    while (drive < drives.size() && pose.stamp >= drives[drive].begins) ++drive;
    const std::int64_t shift_ns = drive == 0 ? 0 : drives[drive - 1].clock_shift_ns.value_or(0);
    all[drive].append(pose.stamp - Duration{shift_ns}, pose.pose);
  }
  return all;
}

}  // namespace loopstone
