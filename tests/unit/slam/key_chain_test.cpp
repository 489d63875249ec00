#include "loopstone/slam/key_chain.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "loopstone/base/byte_archive.hpp"
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

/// Where the front end put the first key scans of stretches.
std::vector<Pose2> firsts(const std::vector<KeyScan>& keys) {
  std::vector<Pose2> poses;
  for (const KeyScan& key : keys) {
    if (key.starts_submap) poses.push_back(key.local_T_robot);
  }
  return poses;
}

TEST(KeyChain, SpellsOutWhatItWasGiven) {
  const auto keys = winding();
  const KeyChain chain = chain_of(keys);
  EXPECT_EQ(chain.stretch_count(), 5U);
  const PoseGraph graph = chain.expand(firsts(keys));
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
  EXPECT_NEAR(chain.travelled_m()[4], way_m, 1e-12);
}

TEST(KeyChain, AThinnedStretchIsOneEdgeThatSaysTheSame) {
  const auto keys = winding();
  const KeyChain whole = chain_of(keys);
  KeyChain thinned = chain_of(keys);
  thinned.thin(1);
  thinned.thin(3);
  EXPECT_EQ(thinned.keys().size(), kKeys - 8);
  EXPECT_EQ(thinned.keys()[6].scan, keys[10].scan);

  // With its ends pulled apart, the chain of single motions costs to first order what the one edge
  // does.
  auto ends = firsts(keys);
  for (std::size_t s = 0; s < ends.size(); ++s)
    ends[s] =
        ends[s] * Pose2{0.002 * static_cast<double>(s), -0.001, 0.0004 * static_cast<double>(s)};
  const auto settled = [&](const KeyChain& chain) {
    PoseGraph graph = chain.expand(ends);
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
  auto ends = firsts(keys);
  ends[1] = ends[1] * Pose2{0.5, 0.0, 0.0};
  const PoseGraph graph = chain.expand(ends);
  double before_m = -1.0;
  for (std::size_t i = 0; i <= 5; ++i) {
    const Pose2 off = keys[i].local_T_robot.inverse() * graph.poses[i];
    const double moved_m = std::hypot(off.x, off.y);
    EXPECT_GT(moved_m, before_m);
    before_m = moved_m;
  }
  EXPECT_NEAR(before_m, 0.5, 1e-12);
}

TEST(KeyChain, WhatIsUncertainAcrossABreakCountsAsTravel) {
  std::vector<KeyScan> keys = winding();
  const KeyChain sound = chain_of(keys);
  keys[10].across = Eigen::Vector3d(0.09, 0.04, 0.01).asDiagonal();
  const KeyChain broken = chain_of(keys);
  EXPECT_EQ(broken.length_m(), sound.length_m()) << "the path is as long as before";
  EXPECT_EQ(broken.travelled_m()[1], sound.travelled_m()[1]);
  // Two standard deviations of 0.3 m, at 0.03 m a metre.
  EXPECT_NEAR(broken.travelled_m()[2], sound.travelled_m()[2] + 20.0, 1e-9);
  EXPECT_NEAR(broken.across(1).covariance.topLeftCorner(2, 2).trace() -
                  sound.across(1).covariance.topLeftCorner(2, 2).trace(),
              0.13, 0.01);
}

TEST(KeyChain, AStateThatContradictsItselfIsRefused) {
  const auto refused = [](std::uint64_t first_scan, std::uint64_t second_scan, std::uint64_t keys,
                          std::uint64_t travelled) {
    ByteWriter writer;
    KeyScan first;
    KeyScan second;
    first.scan = first_scan;
    second.scan = second_scan;
    writer(std::uint64_t{1}, keys);
    if (keys > 0) writer(first, second);
    writer(PoseWithCovariance2{}, travelled);
    for (std::uint64_t i = 0; i < travelled; ++i) writer(0.0);
    writer(second, 1.0, 0.0);
    const std::string bytes = writer.take();
    KeyChain chain(0.03);
    ByteReader reader(bytes);
    try {
      reader(chain);
    } catch (const DataError&) {
      return true;
    }
    return false;
  };
  EXPECT_FALSE(refused(3, 4, 2, 1));
  EXPECT_TRUE(refused(4, 4, 2, 1)) << "two key scans that are one scan";
  EXPECT_TRUE(refused(3, 4, 0, 1)) << "a stretch without key scans";
  EXPECT_TRUE(refused(3, 4, 2, 0)) << "no length of the path";
}

}  // namespace
}  // namespace loopstone
