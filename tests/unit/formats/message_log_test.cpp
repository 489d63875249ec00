#include "loopstone/formats/message_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/messages/message_codec.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using test::pose_near;
using testing::Contains;
using testing::HasSubstr;

constexpr double kPeriodS = 0.1;

template <typename M>
CameMessage came(const std::string& topic, double at_s, const M& message) {
  CameMessage made{topic, MessageType<M>::name(), Stamp::from_seconds(at_s), {}};
  encode_message(WireFormat::kCdr, message, made.bytes);
  return made;
}

msg::TransformStamped transform(double at_s, const std::string& parent, const std::string& child,
                                double x) {
  msg::TransformStamped made{.header = {Stamp::from_seconds(at_s), parent},
                             .child_frame_id = child};
  made.transform.translation.x = x;
  return made;
}

CameMessage scan_at(double at_s) {
  msg::LaserScan scan{.header = {Stamp::from_seconds(at_s), "laser"}};
  scan.angle_min = -1.0F;
  scan.angle_max = 1.0F;
  scan.angle_increment = 0.02F;
  scan.range_max = 20.0F;
  scan.ranges.assign(101, 3.0F);
  return came("/scan", at_s, scan);
}

CameMessage odometry_at(double at_s) {
  msg::Odometry odometry{.header = {Stamp::from_seconds(at_s), "odom"},
                         .child_frame_id = "base_link"};
  odometry.pose.pose.position.x = at_s;
  return came("/odom", at_s, odometry);
}

/// What a robot tells in so many periods, which stands still but for its odometry.
std::deque<CameMessage> some_messages(int periods) {
  std::deque<CameMessage> all;
  all.push_back(
      came("/tf_static", 0.0, msg::TFMessage{{transform(0.0, "base_link", "laser", 0.2)}}));
  for (int i = 0; i < periods; ++i) {
    all.push_back(odometry_at(kPeriodS * i));
    all.push_back(scan_at(kPeriodS * i));
  }
  return all;
}

/// A network on which there is nothing more to come when these have come.
struct Network {
  std::deque<CameMessage> messages{};
  bool is_over = false;

  std::optional<CameMessage> take() {
    is_over = messages.empty();
    if (is_over) return {};
    CameMessage first = std::move(messages.front());
    messages.pop_front();
    return first;
  }
};

struct Read {
  std::unique_ptr<LogReader> log{};
  std::vector<SensorMessage> messages{};

  template <typename M>
  [[nodiscard]] std::vector<M> all() const {
    std::vector<M> found;
    for (const SensorMessage& message : messages) {
      if (const auto* one = std::get_if<M>(&message)) found.push_back(*one);
    }
    return found;
  }
};

/// Until nothing comes any more; the first half is looked at.
Read read(std::deque<CameMessage> messages, LogOptions options = {}) {
  const auto network = std::make_shared<Network>(Network{std::move(messages)});
  const std::size_t half = network->messages.size() / 2;
  options.live = LiveReading{.look_s = 0.01};
  const auto take = [network, half]() -> std::optional<CameMessage> {
    // The look ends by the clock.
    if (network->messages.size() == half)
      std::this_thread::sleep_for(std::chrono::milliseconds(15));
    return network->take();
  };
  bool is_read = false;
  options.stop = [network, &is_read] { return is_read && network->is_over; };
  Read result;
  result.log = open_message_log("a network", take, options);
  is_read = true;
  while (auto message = result.log->next()) result.messages.push_back(std::move(*message));
  return result;
}

TEST(MessageLog, IsUnderstoodAsARecordingIs) {
  const Read result = read(some_messages(20));
  EXPECT_EQ(result.all<LaserScan>().size(), 20U);
  const auto poses = result.all<OdometryPose>();
  ASSERT_EQ(poses.size(), 20U);
  EXPECT_TRUE(pose_near(poses[7].odom_T_robot, {0.7, 0.0, 0.0}, 1e-9, 1e-9));
  EXPECT_EQ(poses[7].stamp, Stamp::from_seconds(0.7));
  ASSERT_EQ(result.log->robot({}).lidars.size(), 1U);
  EXPECT_TRUE(pose_near(result.log->robot({}).lidars[0].robot_T_lidar, {0.2, 0, 0}, 1e-9, 1e-9));
  EXPECT_THAT(result.log->choices(), Contains(HasSubstr("odometry /odom")));
  EXPECT_EQ(result.log->records_skipped(), 0);
}

TEST(MessageLog, MessagesComeInTheirOrder) {
  const Read result = read(some_messages(20));
  for (std::size_t i = 1; i < result.messages.size(); ++i)
    EXPECT_LE(stamp_of(result.messages[i - 1]), stamp_of(result.messages[i]));
}

TEST(MessageLog, WhatIsNoMessageIsCountedAndTold) {
  std::deque<CameMessage> messages = some_messages(20);
  CameMessage cut = scan_at(5.0);
  cut.bytes.resize(cut.bytes.size() / 2);
  const CameMessage noise{"/odom", "nav_msgs/Odometry", {}, std::string(300, '\xff')};
  const CameMessage nothing{"/tf", "tf2_msgs/TFMessage", {}, ""};
  for (const CameMessage& broken : {cut, noise, nothing}) messages.push_back(broken);
  int told = 0;
  const Read result = read(messages, {.on_problem = [&](const LogProblem&) { ++told; }});
  EXPECT_EQ(result.all<LaserScan>().size(), 20U);
  EXPECT_EQ(result.log->records_skipped(), 3);
  EXPECT_EQ(told, 3);
}

TEST(MessageLog, ATopicThatBeginsLaterAndThatNobodyWantsIsLeftOut) {
  std::deque<CameMessage> messages = some_messages(20);
  CameMessage other = scan_at(5.0);
  other.topic = "/another";
  messages.push_back(other);
  EXPECT_EQ(read(messages).all<LaserScan>().size(), 20U);
}

TEST(MessageLog, ATopicThatTheUserNamedHasToBeThere) {
  LogOptions options;
  options.topics.named = {{TopicRole::kLaser, "/front"}};
  EXPECT_THROW((void)read(some_messages(20), options), UsageError);
}

TEST(MessageLog, StopsWhileItWaitsForTheFirstScan) {
  LogOptions options;
  int asked = 0;
  options.stop = [&] { return ++asked > 5; };
  EXPECT_THROW((void)open_message_log(
                   "a network", [] { return std::optional<CameMessage>(); }, options),
               ReadingStopped);
}

}  // namespace
}  // namespace loopstone
