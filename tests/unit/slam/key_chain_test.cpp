#include "loopstone/slam/key_chain.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/graph/solver.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using test::pose_near;

constexpr std::size_t kKeys = 23;

/// A winding way, a submap every five key scans.
std::vector<KeyScan> winding() {
  std::vector<KeyScan> keys;
  Pose2 pose{1.0, -2.0, 0.3};
  for (std::size_t i = 0; i < kKeys; ++i) {
    if (i > 0) pose = pose * exp(Tangent2(0.15, 0.01, 0.1 * std::sin(static_cast<double>(i))));
    const Eigen::Vector3d variance(2e-5, 1e-5, 1e-6);
    keys.push_back({.stamp = {static_cast<std::int64_t>(i) * 200'000'000},
                    .local_T_robot = pose,
                    .covariance = variance.asDiagonal(),
                    .scan = 3 * i,
                    .starts_submap = i % 5 == 0});
  }
  return keys;
}

KeyChain chain_of(const std::vector<KeyScan>& keys) {
  KeyChain chain(0.03);
  for (const KeyScan& key : keys) chain.add(key);
  return chain;
}

/// The graph of the key scans with the stretches at other poses.
PoseGraph expanded(KeyChain chain, const std::vector<Pose2>& map_T_submap) {
  for (std::size_t s = 0; s < map_T_submap.size(); ++s)
    chain.submaps()[s].map_T_submap = map_T_submap[s];
  return chain.expand();
}

TEST(KeyChain, SpellsOutWhatItWasGiven) {
  const auto keys = winding();
  const KeyChain chain = chain_of(keys);
  EXPECT_EQ(chain.submaps().size(), 5U);
  const PoseGraph graph = chain.expand();
  ASSERT_EQ(graph.poses.size(), kKeys);
  ASSERT_EQ(graph.edges.size(), kKeys - 1);
  for (std::size_t i = 0; i < kKeys; ++i)
    EXPECT_TRUE(pose_near(graph.poses[i], keys[i].local_T_robot, 1e-12, 1e-12));
  EXPECT_LT(graph_cost(graph), 1e-15);
  const auto nodes = chain.first_nodes();
  ASSERT_EQ(nodes.size(), 5U);
  for (std::size_t s = 0; s < nodes.size(); ++s) EXPECT_EQ(nodes[s].index, static_cast<int>(5 * s));
  double way_m = 0.0;
  for (std::size_t i = 1; i <= 20; ++i) {
    const Pose2 step = keys[i - 1].local_T_robot.inverse() * keys[i].local_T_robot;
    way_m += std::hypot(step.x, step.y);
  }
  EXPECT_NEAR(chain.submaps()[4].travelled_m, way_m, 1e-12);
}

TEST(KeyChain, AThinnedStretchIsOneEdgeThatSaysTheSame) {
  const auto keys = winding();
  const KeyChain whole = chain_of(keys);
  KeyChain thinned = chain_of(keys);
  thinned.thin({1});
  thinned.thin({3});
  EXPECT_EQ(thinned.keys().size(), kKeys - 8);
  EXPECT_EQ(thinned.keys()[6].scan, keys[10].scan);

  // With its ends pulled apart, the chain of single motions costs to first order what the one edge
  // does.
  auto ends = poses_of(whole.submaps());
  for (std::size_t s = 0; s < ends.size(); ++s)
    ends[s] =
        ends[s] * Pose2{0.002 * static_cast<double>(s), -0.001, 0.0004 * static_cast<double>(s)};
  const auto settled = [&](const KeyChain& chain) {
    PoseGraph graph = expanded(chain, ends);
    for (const NodeId node : chain.first_nodes()) graph.fixed.push_back(node);
    graph.poses = optimize(graph).poses;
    return graph_cost(graph);
  };
  const double cost = settled(whole);
  ASSERT_GT(cost, 0.05);
  EXPECT_NEAR(settled(thinned), cost, 0.01 * cost);
}

TEST(KeyChain, APullIsSharedOutAlongTheWay) {
  const auto keys = winding();
  const KeyChain chain = chain_of(keys);
  auto ends = poses_of(chain.submaps());
  ends[1] = ends[1] * Pose2{0.5, 0.0, 0.0};
  const PoseGraph graph = expanded(chain, ends);
  double before_m = -1.0;
  for (std::size_t i = 0; i <= 5; ++i) {
    const Pose2 off = keys[i].local_T_robot.inverse() * graph.poses[i];
    const double moved_m = std::hypot(off.x, off.y);
    EXPECT_GT(moved_m, before_m);
    before_m = moved_m;
  }
  EXPECT_NEAR(before_m, 0.5, 1e-12);
}

/// With the path broken where the third stretch begins.
std::vector<KeyScan> broken_winding() {
  std::vector<KeyScan> keys = winding();
  keys[10].across = Eigen::Vector3d(0.25, 0.25, 0.01).asDiagonal();
  return keys;
}

TEST(KeyChain, WhatIsLostAcrossABreakIsNotSharedOut) {
  const auto keys = broken_winding();
  const KeyChain chain = chain_of(keys);
  auto ends = poses_of(chain.submaps());
  for (std::size_t s = 2; s < ends.size(); ++s) ends[s] = Pose2{0.5, 0.0, 0.0} * ends[s];
  const PoseGraph graph = expanded(chain, ends);
  for (std::size_t i = 0; i < kKeys; ++i) {
    const Pose2 lost{i < 10 ? 0.0 : 0.5, 0.0, 0.0};
    EXPECT_TRUE(pose_near(graph.poses[i], lost * keys[i].local_T_robot, 1e-9, 1e-9)) << i;
  }
}

TEST(KeyChain, AStretchThatIsThinnedBeforeABreakKeepsItsEnd) {
  const auto keys = broken_winding();
  KeyChain chain = chain_of(keys);
  for (SubmapRecord& submap : chain.submaps()) {
    for (const KeyScan& key : submap.keys)
      submap.scans.add(std::make_shared<const MappedScan>(MappedScan{.index = key.scan}));
  }
  for (int twice = 0; twice < 2; ++twice) {
    chain.thin({0});
    chain.thin({1});
    EXPECT_EQ(chain.submaps()[0].keys.size(), 1U);
    ASSERT_EQ(chain.submaps()[1].keys.size(), 2U);
    EXPECT_EQ(chain.submaps()[1].keys.back().scan, keys[9].scan);
    EXPECT_EQ(chain.submaps()[1].scans.size(), 2U);
    EXPECT_EQ(chain.submaps()[1].scans.share()->back()->index, keys[9].scan);
  }

  const PoseGraph graph = chain.expand();
  ASSERT_EQ(graph.edges.size(), kKeys - 4 - 3 - 1);
  // first stretch 0; second 1, 2; the edge across the break begins at its end.
  EXPECT_LT(graph.edges[0].information.inverse()(0, 0), 0.01);
  EXPECT_LT(graph.edges[1].information.inverse()(0, 0), 0.01);
  EXPECT_GT(graph.edges[2].information.inverse()(0, 0), 0.2);
}

TEST(KeyChain, WhatIsUncertainAcrossABreakCountsAsTravel) {
  std::vector<KeyScan> keys = winding();
  const KeyChain sound = chain_of(keys);
  keys[10].across = Eigen::Vector3d(0.09, 0.04, 0.01).asDiagonal();
  const KeyChain broken = chain_of(keys);
  EXPECT_EQ(broken.length_m(), sound.length_m()) << "the path is as long as before";
  EXPECT_EQ(broken.submaps()[1].travelled_m, sound.submaps()[1].travelled_m);
  // Two standard deviations of 0.3 m, at 0.03 m a metre.
  EXPECT_NEAR(broken.submaps()[2].travelled_m, sound.submaps()[2].travelled_m + 20.0, 1e-9);
  EXPECT_NEAR(broken.submaps()[1].across.covariance.topLeftCorner(2, 2).trace() -
                  sound.submaps()[1].across.covariance.topLeftCorner(2, 2).trace(),
              0.13, 0.01);
}

TEST(KeyChain, ItsOutlineIsTheGraphOfFirstKeyScans) {
  const KeyChain chain = chain_of(winding());
  const PoseGraph outline = chain.outline();
  const PoseGraph whole = chain.expand();
  const auto nodes = chain.first_nodes();
  ASSERT_EQ(outline.poses.size(), nodes.size());
  ASSERT_EQ(outline.edges.size(), nodes.size() - 1);
  for (std::size_t s = 0; s < nodes.size(); ++s) {
    const Pose2& pose = whole.poses[static_cast<std::size_t>(nodes[s].index)];
    EXPECT_TRUE(pose_near(outline.poses[s], pose, 1e-12, 1e-12));
  }
  EXPECT_LT(graph_cost(outline), 1e-15);
}

TEST(KeyChain, WhatWasSharedOfAStretchDoesNotChange) {
  SharedScans scans;
  EXPECT_TRUE(scans.empty());
  for (std::size_t i = 0; i < 3; ++i)
    scans.add(std::make_shared<const MappedScan>(MappedScan{.index = i}));
  const auto shared = scans.share();
  SharedScans copy = scans;
  copy.add(std::make_shared<const MappedScan>(MappedScan{.index = 10}));
  scans.add(std::make_shared<const MappedScan>(MappedScan{.index = 3}));
  EXPECT_EQ(shared->size(), 3U);
  EXPECT_EQ(scans.size(), 4U);
  EXPECT_EQ(copy.size(), 4U);
  EXPECT_EQ(copy.share()->back()->index, 10U);
  scans.thin();
  EXPECT_EQ(scans.size(), 1U);
  EXPECT_EQ(shared->size(), 3U);
}

}  // namespace
}  // namespace loopstone
