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

}  // namespace loopstone
