// What keeps track of odometry, saved at any point: it goes on as if it had not been.

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <string>
#include <variant>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/odometry/gyro_heading.hpp"
#include "loopstone/odometry/odometer.hpp"
#include "loopstone/odometry/odometry_check.hpp"
#include "support/saved_state.hpp"

namespace loopstone {
namespace {

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

/// Right at first, then stuck, then late by 0.3 s: episodes of each kind begin and end.
TEST(OdometryState, OdometryCheck) {
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
  OdometryCheck check;
  for (const MotionPair& pair : pairs) check.add(pair);
  ASSERT_GE(check.episodes().size(), 2u);
  expect_goes_on(OdometryCheck{}, pairs,
                 [](OdometryCheck& object, const auto& pair) { object.add(pair); });
  EXPECT_EQ(restored(check, OdometryCheck{}).episodes().size(), check.episodes().size());
}

}  // namespace
}  // namespace loopstone
