#include "loopstone/slam/back_end.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "loop_scene.hpp"
#include "loopstone/geometry/angle.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using test::empty_submap;
using test::pose_near;
using test::submap_seen_from;

constexpr std::size_t kKeys = 41;
const Pose2 kStart{4.0, 3.0, 0.0};

/// Once around a circle of 40 m and on to where it began, turning `bias` too much at each step.
std::vector<KeyScan> round_trip(double bias_rad) {
  std::vector<KeyScan> keys;
  Pose2 pose;
  for (std::size_t i = 0; i < kKeys; ++i) {
    if (i > 0) pose = pose * exp(Tangent2(1.0, 0.0, 2.0 * kPi / 40.0 + bias_rad));
    const Eigen::Vector3d variance(1e-5, 1e-5, 1e-6);
    keys.push_back({.stamp = {static_cast<std::int64_t>(i) * 1'000'000'000},
                    .local_T_robot = pose,
                    .covariance = variance.asDiagonal(),
                    .scan = i,
                    .starts_submap = i % 10 == 0});
  }
  return keys;
}

/// The trip with a submap every ten keys; the first is of the furnished room, the last of the same
/// room as seen from where the robot stands in it then.
BackEnd after_round_trip(double bias_rad, const Pose2& room_T_last, bool loop_closure = true) {
  MapOptions options;
  options.loop_closure = loop_closure;
  BackEnd back_end(options, {1});
  const auto keys = round_trip(bias_rad);
  const auto room = test::furnished_room();
  for (std::size_t i = 0; i < kKeys; ++i) {
    back_end.add_key(keys[i]);
    if (i == 0)
      back_end.add_submap(submap_seen_from(room, {kStart, {4.6, 3.2, 0.8}, {3.2, 2.5, -2.0}}, 0));
    if (keys[i].starts_submap && i > 0 && i < 40) back_end.add_submap(empty_submap(i));
  }
  back_end.add_submap(submap_seen_from(
      room, {room_T_last, room_T_last * Pose2{0.3, 0.1, 0.8}, room_T_last * Pose2{-0.4, 0.2, 2.5}},
      40));
  return back_end;
}

TEST(BackEnd, AClosurePullsTheDriftOutOfTheLoop) {
  // Twice what the chain holds likely: 40 times 0.6 mrad.
  auto back_end = after_round_trip(0.0006, kStart);
  const auto keys = round_trip(0.0006);
  const double drift_m = std::hypot(keys.back().local_T_robot.x, keys.back().local_T_robot.y);
  ASSERT_GT(drift_m, 0.1);
  back_end.finish();
  ASSERT_EQ(back_end.closures().size(), 1U);
  EXPECT_TRUE(back_end.closures().front().stands())
      << to_string(back_end.closures().front().reason);
  const auto& graph = back_end.graph();
  ASSERT_EQ(graph.poses.size(), kKeys);
  ASSERT_EQ(graph.edges.size(), kKeys) << "a chain and a closure";
  EXPECT_EQ(graph.edges.back().kind, EdgeKind::kLoopClosure);
  EXPECT_TRUE(pose_near(graph.poses.front(), Pose2{}, 1e-12, 1e-12)) << "the gauge";
  EXPECT_TRUE(pose_near(graph.poses.back(), Pose2{}, 0.4 * drift_m, 0.012));
  // The correction is spread: half way round the error has become smaller too.
  const Pose2 truth = round_trip(0.0)[20].local_T_robot;
  const auto error = [&](const Pose2& pose) {
    return std::hypot(pose.x - truth.x, pose.y - truth.y);
  };
  EXPECT_LT(error(graph.poses[20]), error(keys[20].local_T_robot));
}

TEST(BackEnd, RevokesAClosureThatContradictsTheChain) {
  // The chain is good; a room that looks like the first one stands a metre beside the place where
  // that would be.
  auto back_end = after_round_trip(0.0, kStart * Pose2{0.8, -0.7, 0.0});
  back_end.finish();
  ASSERT_FALSE(back_end.closures().empty())
      << "the look-alike was not even seen: this tests nothing";
  for (const auto& closure : back_end.closures()) {
    EXPECT_EQ(closure.state, ClosureState::kRevoked) << to_string(closure.reason);
    EXPECT_EQ(closure.reason, ClosureReason::kContradictsGraph);
    EXPECT_GT(closure.chi2.value(), 26.0);
  }
  EXPECT_EQ(back_end.graph().edges.size(), kKeys - 1);
  const auto keys = round_trip(0.0);
  for (std::size_t i = 0; i < kKeys; ++i) {
    EXPECT_TRUE(pose_near(back_end.graph().poses[i], keys[i].local_T_robot, 0.01, 0.002))
        << "what the false closure bent is straight again";
  }
}

TEST(BackEnd, WithoutLoopClosureTheChainStaysAsItWas) {
  auto back_end = after_round_trip(0.003, kStart, false);
  back_end.finish();
  EXPECT_TRUE(back_end.closures().empty());
  EXPECT_EQ(back_end.submap_count(), 5U);
  const auto keys = round_trip(0.003);
  for (std::size_t i = 0; i < kKeys; ++i) {
    EXPECT_TRUE(pose_near(back_end.graph().poses[i], keys[i].local_T_robot, 1e-9, 1e-9));
  }
}

TEST(BackEnd, NothingIsNothing) {
  BackEnd back_end({}, {1});
  back_end.finish();
  EXPECT_TRUE(back_end.graph().poses.empty());
  EXPECT_TRUE(back_end.graph().edges.empty());
  BackEnd single({}, {1});
  single.add_key({});
  single.finish();
  EXPECT_EQ(single.graph().poses.size(), 1U);
}

constexpr double kReachM = 100.0;
constexpr std::size_t kScans = 50;

/// Two full submaps and an open one, two key scans and another mapped scan in each.
BackEnd::State sound_state() {
  BackEnd::State state;
  for (std::size_t i = 0; i < 3; ++i) {
    SubmapRecord& submap = state.chain.submaps.emplace_back();
    if (i < 2) submap.freeze(empty_submap(2 * i));
    submap.travelled_m = 5.0 * static_cast<double>(i);
    for (std::size_t scan = 10 * i; scan < 10 * i + 3; ++scan) {
      const bool is_key = scan % 2 == 0;
      if (is_key) submap.keys.push_back({.scan = scan});
      submap.scans.add(
          std::make_shared<const MappedScan>(MappedScan{.index = scan, .is_key = is_key}));
    }
  }
  state.closures.push_back({.from_submap = {0}, .to_submap = {1}});
  return state;
}

TEST(BackEnd, AStateThatContradictsItselfIsNotSound) {
  EXPECT_TRUE(is_sound(BackEnd::State{}, 0, kReachM));
  EXPECT_TRUE(is_sound(sound_state(), kScans, kReachM));
  EXPECT_FALSE(is_sound(sound_state(), 20, kReachM)) << "a scan that never came";
  const auto spoiled = [](const auto& spoil) {
    BackEnd::State state = sound_state();
    spoil(state);
    return !is_sound(state, kScans, kReachM);
  };
  using State = BackEnd::State;
  EXPECT_TRUE(spoiled([](State& s) { s.chain.submaps[1].keys.clear(); }));
  EXPECT_TRUE(spoiled([](State& s) { s.chain.submaps[1].scans = {}; }));
  EXPECT_TRUE(spoiled([](State& s) { s.chain.submaps[1].keys[1].scan = 11; }));
  EXPECT_TRUE(spoiled([](State& s) { s.chain.submaps[1].keys[0].scan = 9; }));
  EXPECT_TRUE(spoiled([](State& s) { s.chain.submaps[2].scans = s.chain.submaps[1].scans; }));
  EXPECT_TRUE(spoiled([](State& s) { s.chain.submaps[2].travelled_m = 4.0; }));
  EXPECT_TRUE(spoiled([](State& s) { s.chain.submaps[1].travelled_m = std::nan(""); }));
  EXPECT_TRUE(spoiled([](State& s) { s.chain.submaps[0].state = SubmapState::kOpen; }));
  EXPECT_TRUE(spoiled([](State& s) { s.chain.submaps[0].frozen = nullptr; }));
  EXPECT_TRUE(spoiled([](State& s) { s.chain.submaps[0].closed_with.push_back({2}); }));
  EXPECT_TRUE(spoiled([](State& s) { s.chain.length_m = std::nan(""); }));
  EXPECT_TRUE(spoiled([](State& s) { s.loops.newly_closed.insert({2}); })) << "it is open";
  EXPECT_TRUE(spoiled([](State& s) { s.closures[0].to_submap = {2}; }));
  EXPECT_TRUE(spoiled([](State& s) {
    FinishedSubmap far = empty_submap(0);
    far.submap.surfaces.push_back({.position = {500.0F, 0.0F}});
    s.chain.submaps[0].freeze(std::move(far));
  })) << "larger than the laser reaches";
}

}  // namespace
}  // namespace loopstone
