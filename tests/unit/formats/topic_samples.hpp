#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "formats/recording.hpp"
#include "formats/recording_writer.hpp"
#include "formats/ros_geometry.hpp"
#include "formats/topic_log.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/messages/message_codec.hpp"
#include "support/read_log.hpp"

// Recordings in memory, told message by message, and what is read of them as a log.

namespace loopstone::test {

/// Any stamp of today, so that zero is none.
inline constexpr double kToday = 1.7e9;
[[nodiscard]] inline Stamp today(double seconds) {
  return Stamp{static_cast<std::int64_t>(kToday) * 1'000'000'000} + Duration::from_seconds(seconds);
}

/// What a robot told, in the order of the recorder.
class ToldTopics {
 public:
  struct Message {
    std::size_t topic = 0;
    Stamp recorded{};
    std::string bytes{};
  };

  template <typename M>
  void add(const std::string& name, Stamp recorded, const M& message,
           WireFormat format = WireFormat::kCdr) {
    const std::size_t topic = number_of<M>(name, format);
    std::string bytes;
    encode_message(format, message, bytes);
    messages.push_back({topic, recorded, bytes});
  }
  template <typename M>
  std::size_t number_of(const std::string& name, WireFormat format = WireFormat::kCdr) {
    for (std::size_t i = 0; i < topics.size(); ++i) {
      if (topics[i].name == name && topics[i].type == MessageType<M>::name()) return i;
    }
    topics.push_back({.name = name, .type = MessageType<M>::name(), .format = format});
    return topics.size() - 1;
  }

  void scan(const std::string& name, Stamp stamp, const std::string& frame, double range_m = 2.0,
            std::optional<Stamp> recorded = {}) {
    msg::LaserScan message{.header = {stamp, frame}};
    message.angle_min = -1.0F;
    message.angle_increment = 0.02F;
    message.angle_max = 1.0F;
    message.range_min = 0.1F;
    message.range_max = 30.0F;
    message.ranges.assign(101, static_cast<float>(range_m));
    add(name, recorded.value_or(stamp), message);
  }
  void odometry(const std::string& name, Stamp stamp, const Pose3& pose,
                const std::string& child = "base_link", std::optional<Stamp> recorded = {},
                const std::string& parent = "odom") {
    msg::Odometry message{.header = {stamp, parent}, .child_frame_id = child};
    message.pose.pose.position = {pose.translation.x(), pose.translation.y(), pose.translation.z()};
    message.pose.pose.orientation = {pose.rotation.x(), pose.rotation.y(), pose.rotation.z(),
                                     pose.rotation.w()};
    add(name, recorded.value_or(stamp), message);
  }
  void imu(Stamp stamp, const Eigen::Vector3d& turning, const Eigen::Vector3d& force,
           const std::string& frame = "imu_link", std::optional<Stamp> recorded = {}) {
    msg::Imu message{.header = {stamp, frame}};
    message.angular_velocity = {turning.x(), turning.y(), turning.z()};
    message.linear_acceleration = {force.x(), force.y(), force.z()};
    add("/imu/data", recorded.value_or(stamp), message);
  }
  void tf(const std::string& topic, Stamp stamp, const std::string& parent,
          const std::string& child, const Pose3& pose, std::optional<Stamp> recorded = {}) {
    msg::TransformStamped told{.header = {stamp, parent}, .child_frame_id = child};
    told.transform.translation = {pose.translation.x(), pose.translation.y(), pose.translation.z()};
    told.transform.rotation = {pose.rotation.x(), pose.rotation.y(), pose.rotation.z(),
                               pose.rotation.w()};
    add(topic, recorded.value_or(stamp), msg::TFMessage{{told}});
  }

  std::vector<RecordedTopic> topics{};
  std::vector<Message> messages{};
  bool is_indexed = true;
};

[[nodiscard]] inline Pose3 mount(double x, double y, double z, double roll, double pitch,
                                 double yaw) {
  return Pose3::from_roll_pitch_yaw({x, y, z}, roll, pitch, yaw);
}

/// A recording that gives what was told.
class ToldRecording final : public Recording {
 public:
  explicit ToldRecording(const ToldTopics& told) : told_(told) {
    if (!told_.is_indexed) return;
    topics_ = told_.topics;
    for (RecordedTopic& topic : topics_) topic.messages = 0;
    for (const auto& message : told_.messages) ++*topics_[message.topic].messages;
  }
  [[nodiscard]] const std::vector<RecordedTopic>& topics() const override { return topics_; }
  [[nodiscard]] bool is_indexed() const override { return told_.is_indexed; }
  void want(std::function<bool(const RecordedTopic&)> wanted) override {
    wanted_ = std::move(wanted);
  }
  std::optional<RecordedMessage> next() override {
    while (at_ < told_.messages.size()) {
      const auto& message = told_.messages[at_++];
      while (topics_.size() <= message.topic) topics_.push_back(told_.topics[topics_.size()]);
      if (wanted_ && !wanted_(topics_[message.topic])) continue;
      return RecordedMessage{message.topic,
                             message.recorded,
                             message.bytes,
                             &file_,
                             static_cast<std::int64_t>(at_ - 1),
                             {.at = static_cast<std::int64_t>(at_ - 1)}};
    }
    return std::nullopt;
  }
  std::span<const char> bytes_at(const MessagePlace& place) override {
    return told_.messages.at(static_cast<std::size_t>(place.at)).bytes;
  }
  void rewind() override { at_ = 0; }
  [[nodiscard]] ReadProgress progress() const override {
    return {static_cast<std::int64_t>(at_), static_cast<std::int64_t>(told_.messages.size())};
  }

 private:
  const ToldTopics& told_;
  std::vector<RecordedTopic> topics_{};
  std::function<bool(const RecordedTopic&)> wanted_{};
  std::string file_ = "told";
  std::size_t at_ = 0;
};

/// What is read of a recording, with all that the reader says.
struct ToldLog {
  LogContent content{};
  std::vector<std::string> choices{};
  std::vector<std::string> warnings{};
  std::map<std::string, TopicSummary> topics{};
  RobotModel robot{};
};

[[nodiscard]] inline OpenRecording opener_of(const ToldTopics& told) {
  return [&told](const RecordingOptions&) { return std::make_unique<ToldRecording>(told); };
}

[[nodiscard]] inline ToldLog read_told(const ToldTopics& told, LogOptions options = {}) {
  ToldLog log;
  options.on_problem = [&](const LogProblem& problem) { log.content.problems.push_back(problem); };
  const auto reader = open_topic_log("told", opener_of(told), options);
  while (auto message = reader->next()) log.content.add(std::move(*message));
  log.content.notes = reader->notes();
  log.content.skipped = reader->records_skipped();
  log.choices = reader->choices();
  log.warnings = reader->warnings();
  for (const TopicSummary& topic : reader->topics()) log.topics[topic.name] = topic;
  log.robot = reader->robot({});
  return log;
}

}  // namespace loopstone::test
