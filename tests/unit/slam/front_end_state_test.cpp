// The front end and its parts, saved at any point: they go on as if they had not been. What nothing
// can have led to is refused.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/slam/front_end.hpp"
#include "loopstone/slam/laser_check.hpp"
#include "loopstone/slam/motion_predictor.hpp"
#include "support/saved_state.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

using test::refuses;
using test::restored;
using test::state_of;

const Pose2 kMount{0.1, 0.0, 0.0};
const double kNan = std::nan("");

FrontEndOptions options() { return {.submap_length_m = 3.0}; }

FrontEnd fresh() { return {options(), {}, {}}; }

/// Through the furnished room, wheels 3 % off. A ball of people around the robot for three scans,
/// its cover for five, none for 3 s.
struct Recording {
  std::vector<LaserScan> scans{};
  std::vector<OdometryReading> odometry{};
};

const Recording& recording() {
  static const Recording result = [] {
    Recording recording;
    const auto poses = test::drive_through(
        {{1.0, 1.0}, {6.0, 1.0}, {6.0, 2.5}, {5.5, 5.0}, {1.0, 3.2}, {1.0, 1.2}}, 0.1, 0.1);
    Rng rng(21);
    Pose2 odometry;
    double path_m = 0.0;
    Stamp stamp{1'000'000'000};
    for (std::size_t i = 0; i < poses.size(); ++i) {
      stamp = stamp + Duration{i == 100 ? 3'000'000'000 : 100'000'000};
      auto scan =
          test::scan_from(test::furnished_room(), poses[i], kMount, {.noise_m = 0.01}, &rng);
      scan.stamp = stamp;
      for (std::size_t beam = 0; beam < scan.ranges_m.size(); ++beam) {
        if (i >= 40 && i < 43)
          scan.ranges_m[beam] = 0.4F + 0.1F * static_cast<float>((beam + i) % 7 < 3);
        if (i >= 60 && i < 65) scan.ranges_m[beam] = 0.1F + 0.001F * static_cast<float>(i);
      }
      if (i > 0) {
        const Pose2 step = poses[i - 1].inverse() * poses[i];
        odometry = odometry * Pose2{1.03 * step.x, 1.03 * step.y, step.yaw};
        path_m += std::hypot(step.x, step.y);
      }
      recording.scans.push_back(std::move(scan));
      recording.odometry.push_back({.odom_T_robot = odometry, .path_m = path_m});
    }
    return recording;
  }();
  return result;
}

/// The state after each scan of a front end that is saved, and goes on anew, so often.
std::vector<std::string> states_of_run(std::size_t saved_every) {
  FrontEnd front_end = fresh();
  std::vector<std::string> states;
  for (std::size_t i = 0; i < recording().scans.size(); ++i) {
    if (i % saved_every == saved_every - 1) front_end = restored(front_end, fresh());
    const TrackedScan tracked =
        front_end.add(recording().scans[i], kMount, recording().odometry[i]);
    states.push_back(state_of(front_end, tracked.local_T_robot, tracked.covariance, tracked.key));
  }
  return states;
}

FrontEnd driven(std::size_t scans) {
  FrontEnd front_end = fresh();
  for (std::size_t i = 0; i < scans; ++i)
    (void)front_end.add(recording().scans[i], kMount, recording().odometry[i]);
  return front_end;
}

TEST(FrontEndState, TheRecordingAsksForEverything) {
  FrontEnd front_end = fresh();
  int left_out = 0;
  int breaks = 0;
  std::size_t finished = 0;
  for (std::size_t i = 0; i < recording().scans.size(); ++i) {
    const TrackedScan tracked =
        front_end.add(recording().scans[i], kMount, recording().odometry[i]);
    left_out += tracked.left_out ? 1 : 0;
    breaks += tracked.path_break ? 1 : 0;
    finished += tracked.finished.size();
  }
  EXPECT_GE(left_out, 1);
  EXPECT_GE(breaks, 1);
  EXPECT_GE(finished, 3U);
  EXPECT_GE(front_end.laser_check().episodes().size(), 1U);
}

TEST(FrontEndState, OneThatWasSavedGoesOnAsIfItHadNotBeen) {
  const auto straight = states_of_run(1'000'000);
  for (const std::size_t every : {1U, 13U}) {
    const auto broken = states_of_run(every);
    for (std::size_t i = 0; i < straight.size(); ++i)
      ASSERT_TRUE(broken[i] == straight[i]) << "scan " << i;
  }
}

TEST(FrontEndState, WhatNothingCanHaveLedToIsRefused) {
  const FrontEnd front_end = driven(80);
  using State = FrontEnd::State;
  ASSERT_EQ(front_end.state().active.size(), 2U);
  EXPECT_FALSE(refuses(front_end, [](State& state) { state.active.pop_back(); }));
  EXPECT_TRUE(
      refuses(front_end, [](State& state) { state.active.push_back(state.active.back()); }));
  EXPECT_TRUE(refuses(front_end, [](State& state) { state.active[0].first_key = 1'000; }))
      << "no such key scan";
  EXPECT_TRUE(refuses(front_end, [](State& state) { std::swap(state.active[0], state.active[1]); }))
      << "the newer one first";
  EXPECT_TRUE(refuses(front_end, [](State& state) { state.own.key_count = 0; }));
  EXPECT_TRUE(refuses(front_end, [](State& state) { state.own.held.reset(); }));
  EXPECT_TRUE(refuses(front_end, [](State& state) { state.own.held->usual_seconds = kNan; }));
  EXPECT_TRUE(refuses(front_end, [](State& state) { state.own.lost_in_a_row = -1; }));
  EXPECT_TRUE(refuses(
      front_end, [](State& state) { state.own.lost_in_a_row = std::numeric_limits<int>::max(); }));
  EXPECT_TRUE(refuses(front_end, [](State& state) { state.own.usual_score = kNan; }));
  EXPECT_TRUE(refuses(front_end, [](State& state) { state.active[0].travelled_m = -1.0; }));
  EXPECT_TRUE(
      refuses(front_end, [](State& state) { state.laser_check.lasers.at(0).repeated = 1'000; }));
  EXPECT_TRUE(refuses(front_end, [](State& state) { state.laser_check.lasers.at(0).open = 99; }));
  EXPECT_TRUE(refuses(front_end, [](State& state) { state.views.at(0).piece = 99; }));
  EXPECT_TRUE(refuses(front_end, [](State& state) { state.views.push_back(state.views.at(0)); }))
      << "one laser twice";
  EXPECT_TRUE(refuses(front_end, [](State& state) { state.views.at(0).last_key.x = kNan; }));
  EXPECT_TRUE(
      refuses(front_end, [](State& state) { state.predictor.accuracy.windows.resize(41); }));
}

TEST(FrontEndState, BeforeTheFirstScanThereIsNoneToBeLost) {
  EXPECT_TRUE(refuses(fresh(), [](FrontEnd::State& state) { state.own.lost_in_a_row = 3; }));
}

TEST(FrontEndState, SubmapsOfOtherGridsAreRefused) {
  const FrontEnd::State state = driven(20).state();
  for (const SubmapOptions& other :
       {SubmapOptions{.cell_m = 0.05}, SubmapOptions{.free_cell_m = 0.1}}) {
    FrontEnd front_end(options(), {}, other);
    EXPECT_THROW(front_end.restore(state), UsageError);
  }
  FrontEnd::State levels = state;
  levels.active[0].submap.surfaces = SurfaceGrid{};
  FrontEnd front_end = fresh();
  EXPECT_THROW(front_end.restore(levels), UsageError) << "grids without levels";
}

TEST(FrontEndState, WhatNoMotionCanHaveLedToIsRefused) {
  MotionPredictor predictor;
  for (int i = 0; i < 10; ++i) {
    predictor.settle(Stamp::from_seconds(0.1 * i), {0.1 * i, 0.0, 0.0},
                     OdometryReading{{0.1 * i, 0.0, 0.0}}, {true, true});
  }
  EXPECT_EQ(state_of(restored(predictor, MotionPredictor{})), state_of(predictor));
  using State = MotionPredictor::State;
  EXPECT_TRUE(refuses(predictor, [](State& state) { state.own.steps.resize(4); }));
  EXPECT_TRUE(refuses(predictor, [](State& state) { state.own.last_stamp.reset(); }));
  EXPECT_TRUE(refuses(predictor, [](State& state) { state.own.coast_variance_m2 = 0.0; }))
      << "divided by";
  EXPECT_TRUE(refuses(predictor, [](State& state) { state.own.coast_variance_rad2 = kNan; }));
  EXPECT_TRUE(refuses(predictor, [](State& state) { state.check.lag.lag_s = kNan; }));
}

TEST(FrontEndState, WhatNoLaserCanHaveLedToIsRefused) {
  LaserCheck check;
  LaserScan scan;
  scan.ranges_m.assign(100, 0.1F);
  EXPECT_FALSE(check.add(scan, {})) << "covered";
  EXPECT_FALSE(check.add(scan, {}));
  LaserCheck again = restored(check, LaserCheck{});
  EXPECT_EQ(again.add(scan, {}), check.add(scan, {}));
  EXPECT_EQ(state_of(again), state_of(check));
  using State = LaserCheck::State;
  EXPECT_TRUE(refuses(check, [](State& state) { state.episodes.clear(); })) << "one goes on";
  EXPECT_TRUE(refuses(check, [](State& state) { state.most_repeated = 0; }));
  State state = check.state();
  state.episodes[0].fault = static_cast<LaserFault>(3);
  EXPECT_THROW(test::restore(check, state_of(state)), DataError)
      << "neither blocked, frozen nor covered";
}

}  // namespace
}  // namespace loopstone
