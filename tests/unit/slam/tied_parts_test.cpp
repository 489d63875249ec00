#include "slam/tied_parts.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace loopstone {
namespace {

void join(PoseGraph& graph, int from, int to, EdgeKind kind, double sigma_m) {
  const Eigen::Vector3d sigma(sigma_m, 0.5 * sigma_m, 0.01);
  graph.edges.push_back(
      {NodeId{from}, NodeId{to}, {}, sigma.cwiseAbs2().cwiseInverse().asDiagonal(), kind});
}

/// Nine poses; the path breaks before the third and the sixth.
struct Path {
  PoseGraph graph{};
  std::vector<bool> broken{};

  Path() {
    graph.poses.resize(9);
    broken.resize(9, false);
    broken[3] = broken[6] = true;
    for (int i = 1; i < 9; ++i)
      join(graph, i - 1, i, EdgeKind::kOdometry, broken[static_cast<std::size_t>(i)] ? 0.5 : 0.01);
  }
  [[nodiscard]] std::vector<int> parts() const { return tied_parts(graph, broken, {0.2, 0.02}); }
};

TEST(TiedParts, BreaksSeparateWhatNothingTies) {
  Path path;
  EXPECT_EQ(path.parts(), (std::vector{0, 0, 0, 1, 1, 1, 2, 2, 2}));
  path.graph.edges[2].information *= 10.0;
  EXPECT_EQ(path.parts(), (std::vector{0, 0, 0, 0, 0, 0, 2, 2, 2})) << "odometry knew the way";
  EXPECT_EQ(tied_parts(path.graph, {}, {0.2, 0.02}), std::vector(9, 0)) << "nothing is broken";
}

TEST(TiedParts, LoopClosuresTieWhatTheyKnowWell) {
  Path path;
  join(path.graph, 4, 8, EdgeKind::kLoopClosure, 0.03);
  EXPECT_EQ(path.parts(), (std::vector{0, 0, 0, 1, 1, 1, 1, 1, 1}));
  join(path.graph, 0, 7, EdgeKind::kLoopClosure, 3.0);
  EXPECT_EQ(path.parts(), (std::vector{0, 0, 0, 1, 1, 1, 1, 1, 1})) << "along a corridor";
  join(path.graph, 0, 7, EdgeKind::kLoopClosure, 0.03);
  EXPECT_EQ(path.parts(), std::vector(9, 0));
}

TEST(TiedParts, WhereTheHeadingIsOpenWallsBesideOneAnotherMayBeOthers) {
  Path path;
  join(path.graph, 4, 8, EdgeKind::kLoopClosure, 0.03);
  path.graph.edges.back().information(2, 2) = 1.0 / (0.05 * 0.05);
  EXPECT_EQ(path.parts(), (std::vector{0, 0, 0, 1, 1, 1, 2, 2, 2}));
}

TEST(UntiedBreaks, AreThoseOverWhichThePathAloneKnowsNoMotion) {
  Path path;
  EXPECT_EQ(untied_breaks(path.graph, path.broken, {0.2, 0.02}), path.broken);
  join(path.graph, 0, 7, EdgeKind::kLoopClosure, 0.03);
  join(path.graph, 2, 3, EdgeKind::kLoopClosure, 0.03);
  EXPECT_EQ(untied_breaks(path.graph, path.broken, {0.2, 0.02}), path.broken)
      << "closures may be wrong";
  path.graph.edges[2].information *= 10.0;
  std::vector<bool> second(9, false);
  second[6] = true;
  EXPECT_EQ(untied_breaks(path.graph, path.broken, {0.2, 0.02}), second);
  EXPECT_TRUE(untied_breaks(path.graph, {}, {0.2, 0.02}).empty());
}

}  // namespace
}  // namespace loopstone
