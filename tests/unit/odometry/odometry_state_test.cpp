// What keeps track of odometry, saved at any point: it goes on as if it had not been.

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/odometry/gyro_bias.hpp"
#include "loopstone/odometry/gyro_heading.hpp"
#include "loopstone/odometry/odometer.hpp"
#include "loopstone/odometry/odometry_accuracy.hpp"
#include "loopstone/odometry/odometry_check.hpp"
#include "loopstone/odometry/odometry_lag.hpp"
#include "loopstone/odometry/scan_queue.hpp"
#include "support/saved_state.hpp"

namespace loopstone {
namespace {

using test::refuses;
using test::restored;
using test::state_of;

Stamp at(double seconds) { return Stamp::from_seconds(1000.0 + seconds); }

/// Gives an object the inputs one by one. Whenever `save` says so, a new one is made, given the
/// state and goes on in its place.
/// Returns the state after each input.
template <typename Object, typename Inputs, typename Add, typename Save>
std::vector<std::string> states_of_run(Object object, const Object& fresh, const Inputs& inputs,
                                       Add add, Save save) {
  std::vector<std::string> states;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (save(i)) object = restored(object, fresh);
    add(object, inputs[i]);
    states.push_back(state_of(object));
  }
  return states;
}

template <typename Object, typename Inputs, typename Add>
void expect_goes_on(const Object& fresh, const Inputs& inputs, Add add) {
  const auto straight = states_of_run(fresh, fresh, inputs, add, [](std::size_t) { return false; });
  for (const std::size_t every : {1, 7, 50}) {
    const auto broken =
        states_of_run(fresh, fresh, inputs, add, [&](std::size_t i) { return i % every == 0; });
    for (std::size_t i = 0; i < inputs.size(); ++i) ASSERT_EQ(broken[i], straight[i]) << i;
  }
}

const double kNan = std::nan("");

/// Wheels and gyro of a drive with a halt, a gap in the gyro and a reading that is not a number.
std::vector<SensorMessage> readings() {
  Rng rng(3);
  std::vector<SensorMessage> messages;
  for (int i = 0; i < 800; ++i) {
    const double t = 0.02 * i;
    const bool stands = t > 4.0 && t < 6.0;
    const auto count = [&] { return stands ? 0 : 5 + static_cast<std::int64_t>(rng.below(4)); };
    messages.emplace_back(WheelTicks{at(t), {count(), count(), count(), count()}});
    if (t > 8.0 && t < 9.0) continue;
    const double rate = i == 100 ? std::nan("") : 0.01 + (stands ? 0.0 : 0.3 * std::sin(t));
    messages.emplace_back(ImuSample{at(t + 0.013), {0.0, 0.0, rate}});
  }
  return messages;
}

TEST(OdometryState, OdometerOfWheelsAndGyro) {
  expect_goes_on(Odometer(WheelModel{}), readings(), [](Odometer& odometer, const auto& message) {
    if (const auto* ticks = std::get_if<WheelTicks>(&message)) odometer.add(*ticks);
    if (const auto* imu = std::get_if<ImuSample>(&message)) odometer.add(*imu);
  });
}

TEST(OdometryState, OdometerOfPoses) {
  std::vector<OdometryPose> poses;
  for (int i = 0; i < 300; ++i) poses.push_back({at(0.1 * i), {0.05 * i, 0.0, 0.01 * i}});
  expect_goes_on(Odometer(WheelModel{}), poses, [](Odometer& odometer, const auto& pose) {
    if (pose.stamp == at(10.0)) odometer.restart_at({1.0, 2.0, 0.5}, at(9.95));
    odometer.add(pose);
  });
}

TEST(OdometryState, GyroHeading) {
  std::vector<ImuSample> samples;
  for (const SensorMessage& message : readings()) {
    if (const auto* imu = std::get_if<ImuSample>(&message)) samples.push_back(*imu);
  }
  expect_goes_on(GyroHeading{}, samples,
                 [](GyroHeading& heading, const auto& sample) { heading.add(sample); });
}

/// Right at first, then stuck, then late by 0.3 s.
std::vector<MotionPair> motions() {
  Rng rng(8);
  std::vector<MotionPair> pairs;
  std::vector<Pose2> truth;
  for (int i = 0; i < 1500; ++i) {
    const double turn = std::sin(0.05 * i) * 0.08;
    truth.push_back(exp(Tangent2(0.03 + 0.03 * std::sin(0.11 * i), 0.0, turn)));
    const bool stuck = i > 300 && i < 600;
    const bool late = i > 900;
    const Pose2 said = stuck  ? Pose2{}
                       : late ? truth[static_cast<std::size_t>(i - 3)]
                              : truth.back();
    pairs.push_back({.from = at(0.1 * i),
                     .to = at(0.1 * (i + 1)),
                     .odometry = said,
                     .laser = truth.back() * Pose2{rng.normal(0.0, 0.002), 0.0, 0.0},
                     .sees_translation = i % 11 != 0});
  }
  return pairs;
}

OdometryCheck check_of(const std::vector<MotionPair>& pairs) {
  OdometryCheck check;
  for (const MotionPair& pair : pairs) check.add(pair);
  return check;
}

TEST(OdometryState, OdometryCheck) {
  const std::vector<MotionPair> pairs = motions();
  const OdometryCheck check = check_of(pairs);
  ASSERT_GE(check.episodes().size(), 2u) << "episodes of each kind begin and end";
  expect_goes_on(OdometryCheck{}, pairs,
                 [](OdometryCheck& object, const auto& pair) { object.add(pair); });
  EXPECT_EQ(restored(check, OdometryCheck{}).episodes().size(), check.episodes().size());
}

TEST(OdometryState, OdometryAccuracy) {
  std::vector<int> steps(300);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = static_cast<int>(i);
  expect_goes_on(OdometryAccuracy{}, steps, [](OdometryAccuracy& accuracy, int i) {
    if (i % 90 == 50) accuracy.interrupt();
    accuracy.add({0.11 * i, 0.0, 0.0}, {0.1 * i, 0.01 * i, 0.001 * i}, 0.11 * i);
  });
}

TEST(OdometryState, GyroBias) {
  std::vector<int> steps(100);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = static_cast<int>(i);
  expect_goes_on(GyroBias{}, steps, [](GyroBias& bias, int i) {
    bias.learn(at(0.1 * i), 0.01 + 0.005 * std::sin(1.0 * i));
  });
}

TEST(OdometryState, ScanQueue) {
  std::vector<SensorMessage> messages;
  for (const SensorMessage& message : readings()) {
    messages.push_back(message);
    if (messages.size() % 9 != 0) continue;
    LaserScan scan;
    scan.stamp = stamp_of(message) + Duration{20'000'000};
    scan.ranges_m = {1.0F, 2.0F};
    messages.emplace_back(scan);
  }
  expect_goes_on(ScanQueue(WheelModel{}), messages, [](ScanQueue& queue, const auto& message) {
    queue.add(message);
    while (queue.next()) continue;
  });
}

TEST(OdometryState, WhatNoGyroCanHaveLedToIsRefused) {
  GyroBias bias;
  bias.learn(at(0.0), 0.01);
  EXPECT_TRUE(refuses(bias, [](auto& state) { state.bias_rad_s = kNan; }));
  EXPECT_TRUE(refuses(bias, [](auto& state) { state.variance = -1.0; }));
  GyroHeading heading;
  for (int i = 0; i < 5; ++i) heading.add({at(0.1 * i), {0.0, 0.0, 0.1}});
  EXPECT_FALSE(refuses(heading, [](auto& state) { state.nodes.pop_front(); }));
  EXPECT_TRUE(refuses(heading, [](auto& state) { state.nodes[1].stamp = state.nodes[2].stamp; }));
  EXPECT_TRUE(refuses(heading, [](auto& state) { state.nodes[1].heading_rad = kNan; }));
}

TEST(OdometryState, WhatNoWheelsCanHaveLedToIsRefused) {
  Odometer odometer(WheelModel{});
  for (const SensorMessage& message : readings()) {
    if (const auto* imu = std::get_if<ImuSample>(&message)) odometer.add(*imu);
    if (const auto* ticks = std::get_if<WheelTicks>(&message)) odometer.add(*ticks);
  }
  odometer.add(WheelTicks{at(16.0), {5, 5, 5, 5}});
  ASSERT_FALSE(odometer.state().own.waiting.empty()) << "for the gyro";
  using State = Odometer::State;
  EXPECT_TRUE(refuses(odometer, [](State& state) { state.own.nodes.clear(); }));
  EXPECT_TRUE(refuses(odometer, [](State& state) { state.own.started.reset(); }));
  EXPECT_TRUE(refuses(odometer, [](State& state) { state.own.nodes[1] = state.own.nodes[0]; }));
  EXPECT_TRUE(refuses(odometer, [](State& state) { state.own.rates[1] = state.own.rates[0]; }));
  EXPECT_TRUE(refuses(odometer, [](State& state) { state.own.waiting[0].to = at(-1.0); }));
  EXPECT_TRUE(refuses(odometer, [](State& state) { state.own.turned_by_gyro = -1; }));
  EXPECT_TRUE(
      refuses(odometer, [](State& state) { state.own.nodes[0].odom_T_robot.pose.x = kNan; }));
  EXPECT_TRUE(refuses(odometer, [](State& state) { state.bias.variance = kNan; }));
  State state = odometer.state();
  state.own.source = static_cast<Odometer::Source>(3);
  EXPECT_THROW(test::restore(odometer, state_of(state)), DataError) << "neither wheels nor poses";
}

TEST(OdometryState, WhatNoScansCanHaveLedToIsRefused) {
  ScanQueue queue(WheelModel{});
  queue.add(LaserScan{.stamp = at(0.0)});
  using State = ScanQueue::State;
  EXPECT_TRUE(refuses(queue, [](State& state) { state.own.first.reset(); }));
  EXPECT_TRUE(refuses(queue, [](State& state) { state.own.travel.path_m = -1.0; }));
  EXPECT_TRUE(refuses(queue, [](State& state) { state.own.travel.turned_rad = kNan; }));
  EXPECT_TRUE(refuses(queue, [](State& state) { state.gyro.nodes = {{at(1.0)}, {at(0.0)}}; }));
  EXPECT_TRUE(
      refuses(queue, [](State& state) { state.odometer.own.source = Odometer::Source::kWheels; }));
}

TEST(OdometryState, WhatNoMotionsCanHaveLedToIsRefused) {
  const OdometryCheck check = check_of(motions());
  ASSERT_FALSE(check.state().lag.steps.empty());
  using State = OdometryCheck::State;
  EXPECT_TRUE(refuses(check, [](State& state) { state.own.distrusted_s = kNan; }));
  EXPECT_TRUE(refuses(check, [](State& state) { state.translation.pieces.resize(11); }));
  EXPECT_TRUE(refuses(check, [](State& state) { state.rotation.wrong_in_a_row = -1; }));
  EXPECT_TRUE(refuses(check, [](State& state) {
    state.rotation.right_count = std::numeric_limits<int>::max();
  })) << "it could not be counted on";
  EXPECT_TRUE(
      refuses(check, [](State& state) { state.rotation.jumps = std::numeric_limits<int>::min(); }));
  EXPECT_TRUE(refuses(check, [](State& state) { state.lag.steps.resize(257); }));
  EXPECT_TRUE(refuses(check, [](State& state) { state.lag.steps[1].from.nanoseconds += 1; }));
  EXPECT_TRUE(refuses(check, [](State& state) { state.lag.lag_s = kNan; }));

  OdometryAccuracy accuracy;
  for (int i = 0; i < 100; ++i) accuracy.add({0.1 * i, 0.0, 0.0}, {0.1 * i, 0.0, 0.0}, 0.1 * i);
  EXPECT_TRUE(refuses(accuracy, [](auto& state) { state.windows.resize(41); }));
  EXPECT_TRUE(refuses(accuracy, [](auto& state) { state.windows[0].told.yaw = kNan; }));
  EXPECT_TRUE(refuses(accuracy, [](auto& state) { state.windows[1].way_m = 0.0; })) << "divided by";
}

TEST(OdometryState, FaultsAndPartsThatThereAreNotAreRefused) {
  OdometryCheck check = check_of(motions());
  ASSERT_FALSE(check.episodes().empty());
  auto state = check.state();
  state.own.episodes[0].fault = static_cast<OdometryFault>(6);
  EXPECT_THROW(test::restore(check, state_of(state)), DataError);
  state = check.state();
  state.own.episodes[0].part = static_cast<OdometryPart>(-1);
  EXPECT_THROW(test::restore(check, state_of(state)), DataError);
}

}  // namespace
}  // namespace loopstone
