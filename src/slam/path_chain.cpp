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

}  // namespace loopstone
