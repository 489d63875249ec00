#include "loopstone/slam/path_break.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace loopstone {
namespace {

RelativePoseEdge edge(int from, int to, double sigma_m, EdgeKind kind) {
  const double information = 1.0 / (sigma_m * sigma_m);
  return {NodeId{from}, NodeId{to}, Pose2{1.0, 0.0, 0.0},
          Eigen::Vector3d(information, information, 1e4).asDiagonal(), kind};
}

/// Six poses in a row, ten scans apart; between the third and the fourth the laser was blind.
struct Path {
  PoseGraph graph{};
  std::vector<std::size_t> scans{};
  std::vector<PathBreak> breaks{};
};

Path path_with_gap(double sigma_m) {
  Path path;
  for (int i = 0; i < 6; ++i) {
    path.graph.poses.push_back({static_cast<double>(i), 0.0, 0.0});
    path.scans.push_back(10 * static_cast<std::size_t>(i));
    if (i > 0)
      path.graph.edges.push_back(edge(i - 1, i, i == 3 ? sigma_m : 0.01, EdgeKind::kOdometry));
  }
  PathBreak gap{.to_scan = 30, .bridge = BreakBridge::kOdometry};
  gap.covariance.diagonal() << sigma_m * sigma_m, 0.25 * sigma_m * sigma_m, 0.1;
  path.breaks.push_back(gap);
  return path;
}

TEST(PathBreak, WithoutClosuresTheBridgeIsAllThereIs) {
  Path path = path_with_gap(0.8);
  find_ties(path.breaks, path.graph, path.scans);
  EXPECT_EQ(path.breaks[0].closures, 0);
  EXPECT_NEAR(path.breaks[0].tie_sigma_m, 0.8, 1e-9);
}

TEST(PathBreak, ClosuresThatLeadAcrossTieBothSides) {
  Path path = path_with_gap(0.8);
  path.graph.edges.push_back(edge(0, 5, 0.03, EdgeKind::kLoopClosure));
  path.graph.edges.push_back(edge(1, 4, 0.05, EdgeKind::kLoopClosure));
  path.graph.edges.push_back(edge(0, 2, 0.01, EdgeKind::kLoopClosure));  // leads nowhere
  find_ties(path.breaks, path.graph, path.scans);
  EXPECT_EQ(path.breaks[0].closures, 2);
  // 2 -> 0 by the closure beside the path, 0 -> 5, and back to 3 along the path.
  EXPECT_NEAR(path.breaks[0].tie_sigma_m, std::sqrt(0.01 * 0.01 + 0.03 * 0.03 + 2 * 0.01 * 0.01),
              1e-9);
}

TEST(PathBreak, ClosuresThatKnowLessThanTheBridgeTieNothing) {
  Path path = path_with_gap(0.02);
  path.graph.edges.push_back(edge(1, 4, 0.5, EdgeKind::kLoopClosure));
  find_ties(path.breaks, path.graph, path.scans);
  EXPECT_EQ(path.breaks[0].closures, 0);
  EXPECT_NEAR(path.breaks[0].tie_sigma_m, 0.02, 1e-9);
}

}  // namespace
}  // namespace loopstone
