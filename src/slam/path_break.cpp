#include "loopstone/slam/path_break.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <utility>

#include "slam/front_end_numbers.hpp"
#include "slam/pose_search.hpp"

namespace loopstone {

namespace {

/// Least sum of the edges' variances from one node to another [m^2], leaving out the edges that
/// join the two themselves along the path. Infinite when nothing else leads there.
double variance_between(const PoseGraph& graph, int from, int to) {
  std::vector<std::vector<std::pair<int, double>>> neighbours(graph.poses.size());
  for (const RelativePoseEdge& edge : graph.edges) {
    if (edge.kind == EdgeKind::kOdometry && edge.from.index == from && edge.to.index == to)
      continue;
    const double variance_m2 = position_variance_m2(edge.information.inverse());
    neighbours[static_cast<std::size_t>(edge.from.index)].emplace_back(edge.to.index, variance_m2);
    neighbours[static_cast<std::size_t>(edge.to.index)].emplace_back(edge.from.index, variance_m2);
  }
  std::vector<double> least(graph.poses.size(), std::numeric_limits<double>::infinity());
  using Item = std::pair<double, int>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> open;
  least[static_cast<std::size_t>(from)] = 0.0;
  open.push({0.0, from});
  while (!open.empty()) {
    const auto [variance_m2, at] = open.top();
    open.pop();
    if (at == to) return variance_m2;
    if (variance_m2 > least[static_cast<std::size_t>(at)]) continue;
    for (const auto& [next, more] : neighbours[static_cast<std::size_t>(at)]) {
      double& known = least[static_cast<std::size_t>(next)];
      if (variance_m2 + more >= known) continue;
      known = variance_m2 + more;
      open.push({known, next});
    }
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

double PathBreak::bridge_sigma_m() const { return std::sqrt(position_variance_m2(covariance)); }

// See FrontEnd::turn_to_match().
bool PathBreak::was_found_in_part() const {
  return cause == BreakCause::kNoScans && bridge == BreakBridge::kNothing &&
         bridge_sigma_m() <= 1.01 * kFrontEndRejoin.found_m;
}

// See FrontEnd::begin_along().
bool PathBreak::may_be_carried() const {
  return cause == BreakCause::kNoScans && bridge == BreakBridge::kOdometry &&
         odometry_m <= kFrontEndRejoin.short_m &&
         bridge_sigma_m() >= kFrontEndRejoin.carried_along_m;
}

void find_ties(std::vector<PathBreak>& breaks, const PoseGraph& graph,
               std::span<const std::size_t> node_scans) {
  for (PathBreak& gap : breaks) {
    gap.closures = 0;
    gap.tie_sigma_m = gap.bridge == BreakBridge::kLaser ? 0.0 : gap.bridge_sigma_m();
    const auto after = static_cast<int>(
        std::lower_bound(node_scans.begin(), node_scans.end(), gap.to_scan) - node_scans.begin());
    if (gap.bridge == BreakBridge::kLaser || after == 0 ||
        after == static_cast<int>(node_scans.size())) {
      continue;
    }
    for (const RelativePoseEdge& edge : graph.edges) {
      const auto [first, last] = std::minmax(edge.from.index, edge.to.index);
      if (edge.kind == EdgeKind::kLoopClosure && first < after && last >= after) ++gap.closures;
    }
    if (gap.closures == 0) continue;
    const double sigma_m = std::sqrt(variance_between(graph, after - 1, after));
    // Closures that lead across by way of what is less certain still tie nothing.
    if (!(sigma_m < gap.tie_sigma_m)) gap.closures = 0;
    gap.tie_sigma_m = std::min(gap.tie_sigma_m, sigma_m);
  }
}

}  // namespace loopstone
