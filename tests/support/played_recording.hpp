#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "formats/recording.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/messages/message_codec.hpp"

namespace loopstone::test {

[[nodiscard]] inline Pose2 to_pose2(const msg::Pose& pose) {
  return {pose.position.x, pose.position.y,
          2.0 * std::atan2(pose.orientation.z, pose.orientation.w)};
}
[[nodiscard]] inline Pose2 to_pose2(const msg::Transform& transform) {
  return {transform.translation.x, transform.translation.y,
          2.0 * std::atan2(transform.rotation.z, transform.rotation.w)};
}

/// All of an MCAP recording, read back.
class PlayedRecording {
 public:
  template <typename M>
  struct Message {
    Stamp recorded{};
    M value{};
  };

  explicit PlayedRecording(const std::string& path) {
    RecordingOptions options;
    options.on_damage = [](const Problem& problem) { ADD_FAILURE() << problem.reason; };
    const auto recording = open_mcap(path, options);
    EXPECT_TRUE(recording->is_indexed());
    while (const auto message = recording->next()) {
      const std::string& topic = recording->topics()[message->topic].name;
      bytes_[topic].push_back({message->recorded, {message->bytes.begin(), message->bytes.end()}});
    }
    for (const RecordedTopic& topic : recording->topics()) topics_[topic.name] = topic;
    EXPECT_TRUE(recording->notes().empty());
  }

  [[nodiscard]] const std::map<std::string, RecordedTopic>& topics() const { return topics_; }

  /// In the order of the file. Whether the topic is of this type is tested, too.
  template <typename M>
  [[nodiscard]] std::vector<Message<M>> all(const std::string& name) const {
    std::vector<Message<M>> messages;
    const auto topic = topics_.find(name);
    if (topic == topics_.end()) return messages;
    EXPECT_EQ(topic->second.type, MessageType<M>::name());
    EXPECT_EQ(topic->second.hash, MessageType<M>::rihs01());
    EXPECT_EQ(topic->second.definition.text, MessageType<M>::ros2_definition());
    const MessageDecoder<M> decoder(WireFormat::kCdr);
    for (const auto& [recorded, bytes] : bytes_.at(name)) {
      messages.push_back({recorded, {}});
      decoder.decode(bytes, messages.back().value);
    }
    return messages;
  }

 private:
  std::map<std::string, RecordedTopic> topics_{};
  std::map<std::string, std::vector<std::pair<Stamp, std::string>>> bytes_{};
};

/// Closures of a state that the markers show.
[[nodiscard]] inline std::size_t lines_of(const msg::MarkerArray& array, const std::string& state) {
  std::size_t lines = 0;
  for (const msg::Marker& marker : array.markers) {
    if (marker.ns == state && marker.action == msg::Marker::kAdd) lines += marker.points.size() / 2;
  }
  return lines;
}

}  // namespace loopstone::test
