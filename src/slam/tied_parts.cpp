#include "slam/tied_parts.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "loopstone/geometry/covariance.hpp"

namespace loopstone {

namespace {

bool ties(const RelativePoseEdge& edge, const TieBounds& bounds) {
  const Eigen::Matrix3d covariance = edge.information.inverse();
  return largest_sigma(covariance.topLeftCorner<2, 2>()) <= bounds.near_m &&
         std::sqrt(covariance(2, 2)) <= bounds.near_rad;
}

}  // namespace

std::vector<int> tied_parts(const PoseGraph& graph, const std::vector<bool>& broken,
                            const TieBounds& bounds) {
  std::vector<int> piece(graph.poses.size(), 0);
  if (std::ranges::none_of(broken, [](bool is_broken) { return is_broken; })) return piece;
  for (std::size_t i = 1; i < piece.size(); ++i) piece[i] = piece[i - 1] + (broken[i] ? 1 : 0);
  std::vector<int> part(piece.empty() ? 0 : static_cast<std::size_t>(piece.back()) + 1);
  std::iota(part.begin(), part.end(), 0);
  for (const RelativePoseEdge& edge : graph.edges) {
    const int a = part[static_cast<std::size_t>(piece[static_cast<std::size_t>(edge.from.index)])];
    const int b = part[static_cast<std::size_t>(piece[static_cast<std::size_t>(edge.to.index)])];
    if (a != b && ties(edge, bounds)) std::ranges::replace(part, std::max(a, b), std::min(a, b));
  }
  for (int& of_pose : piece) of_pose = part[static_cast<std::size_t>(of_pose)];
  return piece;
}

std::vector<bool> untied_breaks(const PoseGraph& graph, std::vector<bool> broken,
                                const TieBounds& bounds) {
  if (broken.empty()) return broken;
  for (const RelativePoseEdge& edge : graph.edges) {
    const bool is_of_path =
        edge.kind != EdgeKind::kLoopClosure && edge.to.index == edge.from.index + 1;
    if (is_of_path && ties(edge, bounds)) broken[static_cast<std::size_t>(edge.to.index)] = false;
  }
  return broken;
}

}  // namespace loopstone
