// A mapper that was saved and put back in another one: the result is the same bytes.

#include "loopstone/slam/mapper_state.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <future>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/base/byte_archive.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/slam/mapper.hpp"
#include "support/saved_state.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

using test::Scanner;
using test::state_of;
using test::Walls;

/// Twice around a block: places are seen again, submaps fill up, sweeps take time. Odometry is 3 %
/// off and stops for a while.
const std::vector<SensorMessage>& recording() {
  static const std::vector<SensorMessage> result = [] {
    const Walls ring = test::together(
        {test::rectangle({0.0, 0.0}, {9.0, 7.0}), test::rectangle({2.5, 2.5}, {6.5, 4.5}),
         test::rectangle({4.0, 0.0}, {4.7, 0.4}), test::rectangle({8.4, 3.0}, {9.0, 3.6}),
         test::rectangle({5.0, 6.5}, {5.8, 7.0}), test::rectangle({2.1, 3.0}, {2.5, 3.3})});
    const auto poses = test::drive_through({{1.2, 1.2},
                                            {7.8, 1.2},
                                            {7.8, 5.8},
                                            {1.2, 5.8},
                                            {1.2, 1.3},
                                            {7.7, 1.3},
                                            {7.7, 5.7},
                                            {1.3, 5.7}},
                                           0.1, 0.15);
    const Scanner scanner{.angle_increment_rad = radians(2.0),
                          .beams = 136,
                          .range_max_m = 15.0,
                          .time_increment_s = 0.0003,
                          .noise_m = 0.01};
    Rng rng(2);
    std::vector<SensorMessage> messages;
    Pose2 odometry;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const Stamp stamp{static_cast<std::int64_t>(i + 1) * 100'000'000};
      Tangent2 velocity = Tangent2::Zero();
      if (i > 0) {
        const Pose2 step = poses[i - 1].inverse() * poses[i];
        velocity = log(step) / 0.1;
        odometry = odometry * Pose2{1.03 * step.x, 0.0, step.yaw + 0.001};
      }
      auto scan = test::scan_from(ring, poses[i], {0.1, 0.0, 0.0}, scanner, &rng, velocity);
      scan.stamp = stamp;
      scan.robot_T_lidar = Pose2{0.1, 0.0, 0.0};
      // The scan comes first and has to wait; for a while nothing comes that it could wait for.
      messages.emplace_back(std::move(scan));
      if (i < 150 || i > 190) messages.emplace_back(OdometryPose{stamp + Duration{1}, odometry});
    }
    return messages;
  }();
  return result;
}

MapOptions options() {
  MapOptions options;
  options.front_end.submap_length_m = 4.0;
  return options;
}

/// All of a result that is not a time.
std::string bytes_of(const MapResult& result) {
  std::string bytes = state_of(
      result.node_stamps, result.graph, result.loop_closures, result.map.log_odds,
      result.map.observed, result.odometry_episodes, result.statistics.scans,
      result.statistics.searches, result.statistics.scans_dropped,
      result.statistics.degenerate_travel_m, result.statistics.graph_cost,
      result.statistics.odometry_translation_scale, result.statistics.odometry_distrusted_s);
  for (const Trajectory* trajectory : {&result.trajectory, &result.odometry}) {
    for (const StampedPose2& pose : trajectory->poses()) bytes += state_of(pose.stamp, pose.pose);
  }
  for (const std::string& warning : result.warnings) bytes += warning;
  return bytes;
}

/// The result of a run that is broken off after each of these numbers of messages and goes on in a
/// new mapper.
MapResult run(const std::vector<std::size_t>& breaks, int threads) {
  auto mapper = std::make_unique<Mapper>(RobotModel{}, options(), Threads{threads});
  for (std::size_t i = 0; i < recording().size(); ++i) {
    for (const std::size_t at : breaks) {
      if (at != i) continue;
      MapperState saved = mapper->save_state().get();
      mapper = std::make_unique<Mapper>(RobotModel{}, options(), Threads{threads});
      mapper->restore_state(std::move(saved));
    }
    mapper->add(recording()[i]);
  }
  return mapper->finish();
}

const MapResult& unbroken() {
  static const MapResult result = run({}, 1);
  return result;
}

TEST(MapperState, TheRecordingAsksForEverything) {
  EXPECT_GE(unbroken().statistics.loop_closures_accepted, 1);
  EXPECT_GE(unbroken().statistics.submaps, 5);
  EXPECT_FALSE(unbroken().odometry.empty());
}

TEST(MapperState, ARunThatWasBrokenOffAnywhereEndsTheSame) {
  const std::string expected = bytes_of(unbroken());
  const std::size_t size = recording().size();
  for (const int threads : {1, 2}) {
    EXPECT_EQ(bytes_of(run({}, threads)), expected);
    EXPECT_EQ(bytes_of(run({0, 1, size / 4, size / 2 + 1}, threads)), expected) << threads;
    EXPECT_EQ(bytes_of(run({size - 1}, threads)), expected) << threads;
    std::vector<std::size_t> often;
    for (std::size_t i = 0; i < size; i += 37) often.push_back(i);
    EXPECT_EQ(bytes_of(run(often, threads)), expected) << threads;
  }
}

TEST(MapperState, SavingChangesNothingAndTellsTheSameForAnyNumberOfThreads) {
  std::vector<std::string> states;
  for (const int threads : {1, 2}) {
    Mapper mapper({}, options(), {threads});
    std::vector<std::future<MapperState>> waiting;
    for (std::size_t i = 0; i < recording().size(); ++i) {
      if (i % 50 == 0) waiting.push_back(mapper.save_state());  // not waited for
      mapper.add(recording()[i]);
    }
    MapperState state = mapper.save_state().get();
    state.so_far.statistics.front_end_s = 0.0;
    state.back_end.loop_closing_s = state.back_end.optimisation_s = 0.0;
    states.push_back(state_of(state));
    EXPECT_EQ(bytes_of(mapper.finish()), bytes_of(unbroken()));
    std::size_t scans = 0;
    for (auto& saved : waiting) {
      const std::size_t more = saved.get().so_far.track.size();
      EXPECT_GE(more, scans);
      scans = more;
    }
    EXPECT_GT(scans, 100U);
  }
  EXPECT_EQ(states[0], states[1]);
}

class MapperStateDamaged : public testing::Test {
 protected:
  void SetUp() override {
    Mapper mapper({}, options(), {1});
    for (std::size_t i = 0; i < 100; ++i) mapper.add(recording()[i]);
    good = mapper.save_state().get();
  }
  template <typename Spoil>
  [[nodiscard]] bool refused(Spoil&& spoil) const {
    MapperState state = good;
    spoil(state);
    Mapper mapper({}, options(), {1});
    try {
      mapper.restore_state(std::move(state));
    } catch (const UsageError&) {
      return true;
    }
    return false;
  }
  MapperState good{};
};

TEST_F(MapperStateDamaged, IndexesThatPointAtNothingAreRefused) {
  using State = MapperState;
  ASSERT_FALSE(good.waiting.empty());
  ASSERT_FALSE(good.back_end.chain.submaps.empty());
  EXPECT_FALSE(refused([](State&) {}));
  EXPECT_TRUE(refused([](State& s) { s.so_far.track.clear(); })) << "scans that never came";
  EXPECT_TRUE(refused([](State& s) { s.so_far.breaks.push_back({.to_scan = 1000}); }));
  EXPECT_TRUE(refused([](State& s) { s.so_far.submaps_frozen = s.so_far.submaps_opened + 1; }));
  EXPECT_TRUE(refused([](State& s) { s.so_far.gyro_scans = -1; }));
  EXPECT_TRUE(refused([](State& s) { s.back_end.chain.submaps.front().keys.clear(); }));
  EXPECT_TRUE(refused([](State& s) { s.back_end.loops.newly_closed.insert({1000}); }));
  EXPECT_TRUE(refused([](State& s) { s.waiting.push_back(s.waiting.front()); })) << "twice";
  EXPECT_TRUE(refused([](State& s) { s.waiting.front().key.emplace().scan = 0; }));
  EXPECT_TRUE(refused([](State& s) { s.waiting.front().scan = nullptr; }));
  EXPECT_TRUE(refused([](State& s) {
    s.back_end = {};
    s.waiting.front().key.reset();
  })) << "a scan of no submap";
}

/// A run that goes on from a state with any one number changed is refused or ends like another.
TEST_F(MapperStateDamaged, WhatIsNotRefusedGoesOn) {
  Rng rng(1);
  const std::string whole = state_of(good);
  int refusals = 0;
  for (int trial = 0; trial < 60; ++trial) {
    std::string bytes = whole;
    for (std::size_t at = rng.below(bytes.size()), i = 0; i < 4 && at + i < bytes.size(); ++i) {
      bytes[at + i] = static_cast<char>(rng.below(256));
    }
    Mapper mapper({}, options(), {1});
    try {
      MapperState state;
      test::restore(state, bytes);
      mapper.restore_state(std::move(state));
      for (std::size_t i = 100; i < 130; ++i) mapper.add(recording()[i]);
      (void)mapper.finish();
    } catch (const DataError&) {
      ++refusals;
    } catch (const UsageError&) {
      ++refusals;  // or poses so far apart that there is no map of them
    }
  }
  EXPECT_GT(refusals, 0);
}

TEST_F(MapperStateDamaged, OtherOptionsOfTheGridsAreRefused) {
  MapOptions other = options();
  other.submap.cell_m = 0.05;
  Mapper mapper({}, other, {1});
  EXPECT_THROW(mapper.restore_state(good), UsageError);
}

}  // namespace
}  // namespace loopstone
