#include "slam/tied_parts.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include "loopstone/geometry/covariance.hpp"

namespace loopstone {

namespace {

bool ties(const RelativePoseEdge& edge, double near_m) {
  const Eigen::Matrix3d covariance = edge.information.inverse();
  return largest_sigma(covariance.topLeftCorner<2, 2>()) <= near_m;
}

}  // namespace

std::vector<int> tied_parts(const PoseGraph& graph, const std::vector<bool>& broken,
                            double near_m) {
  std::vector<int> piece(graph.poses.size(), 0);
  if (std::ranges::none_of(broken, [](bool is_broken) { return is_broken; })) return piece;
  for (std::size_t i = 1; i < piece.size(); ++i) piece[i] = piece[i - 1] + (broken[i] ? 1 : 0);
  std::vector<int> part(piece.empty() ? 0 : static_cast<std::size_t>(piece.back()) + 1);
  std::iota(part.begin(), part.end(), 0);
  for (const RelativePoseEdge& edge : graph.edges) {
    const int a = part[static_cast<std::size_t>(piece[static_cast<std::size_t>(edge.from.index)])];
    const int b = part[static_cast<std::size_t>(piece[static_cast<std::size_t>(edge.to.index)])];
    if (a != b && ties(edge, near_m)) std::ranges::replace(part, std::max(a, b), std::min(a, b));
  }
  for (int& of_pose : piece) of_pose = part[static_cast<std::size_t>(of_pose)];
  return piece;
}

}  // namespace loopstone
