#include "loopstone/slam/map_result.hpp"

#include <algorithm>
#include <span>

namespace loopstone {

namespace {

/// What is added where the laser did not hold the pose: nothing at both ends of a break that it
/// ended; between them a path that leads from one to the other.
Eigen::Matrix3d of_breaks(std::span<const PathBreak> breaks, Stamp stamp) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const PathBreak& gap : breaks) {
    if (stamp <= gap.from || stamp > gap.to) continue;
    const double share = (stamp - gap.from).seconds() / (gap.to - gap.from).seconds();
    sum += (gap.ends_log ? share * share : share * (1.0 - share)) * gap.covariance;
  }
  return sum;
}

/// Between key scans that of both.
Eigen::Matrix3d of_nodes(const MapResult& result, Stamp stamp) {
  const auto& stamps = result.node_stamps;
  const auto covariance = [&](auto at) {
    return result.covariances.of(NodeId{static_cast<int>(at - stamps.begin())});
  };
  const auto later = std::ranges::lower_bound(stamps, stamp);
  if (later == stamps.begin()) return covariance(later);
  if (later == stamps.end()) return covariance(later - 1);
  const auto earlier = later - 1;
  const double share = (stamp - *earlier).seconds() / (*later - *earlier).seconds();
  return (1.0 - share) * covariance(earlier) + share * covariance(later);
}

}  // namespace

Eigen::Matrix3d MapResult::covariance_at(Stamp stamp) const {
  return of_nodes(*this, stamp) + of_breaks(breaks, stamp);
}

Duration MapResult::clock_shift(std::size_t drive) const {
  return {drive == 0 ? 0 : drives[drive - 1].clock_shift_ns.value_or(0)};
}

std::vector<Trajectory> MapResult::trajectories() const {
  std::vector<Trajectory> all(drives.size() + 1);
  std::size_t drive = 0;
  for (const StampedPose2& pose : trajectory.poses()) {
    while (drive < drives.size() && pose.stamp >= drives[drive].begins) ++drive;
    all[drive].append(pose.stamp - clock_shift(drive), pose.pose);
  }
  return all;
}

}  // namespace loopstone
