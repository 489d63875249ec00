#include "loopstone/localization/localization_result.hpp"

#include <utility>

namespace loopstone {

Trajectory LocalizationResult::trajectory() const {
  std::vector<StampedPose2> poses;
  poses.reserve(estimates.size());
  for (const LocalizationEstimate& estimate : estimates)
    poses.push_back({estimate.stamp, estimate.map_T_robot});
  return Trajectory(std::move(poses));
}

}  // namespace loopstone
