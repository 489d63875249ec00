#include "slam/path_chain.hpp"

#include "slam/loose_parts_numbers.hpp"

namespace loopstone {

Eigen::Vector2d way_at(std::span<const Pose2> poses, std::size_t edge) {
  std::size_t first = edge;
  std::size_t last = edge + 1;
  const auto way = [&]() -> Eigen::Vector2d {
    return poses[last].translation() - poses[first].translation();
  };
  for (int i = 0; i < kLooseParts.way_steps && way().norm() < kLooseParts.way_m; ++i) {
    if (first > 0) --first;
    if (last + 1 < poses.size()) ++last;
  }
  return way().stableNormalized();
}

PathChain with_open_ways_known(std::span<const Pose2> poses, PathChain chain) {
  for (std::size_t i = 0; i < chain.drifts.size(); ++i) {
    if (!chain.open[i]) continue;
    const Eigen::Vector2d along = way_at(poses, i);
    Eigen::Matrix3d beside = Eigen::Matrix3d::Identity();
    beside.topLeftCorner<2, 2>() -= along * along.transpose();
    chain.drifts[i] = beside * chain.drifts[i] * beside;
    chain.open[i] = false;
    chain.off[i].setZero();
  }
  return chain;
}

}  // namespace loopstone
