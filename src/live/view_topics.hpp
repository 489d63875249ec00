#pragma once

#include <functional>
#include <optional>
#include <string>

#include "live/view_json.hpp"
#include "loopstone/live/view_channel.hpp"
#include "loopstone/messages/message_codec.hpp"

// The topics of the live view.

namespace loopstone {

/// A topic whose messages are ROS 2's.
template <typename M>
[[nodiscard]] ViewChannel ros_channel(std::string_view topic, SendPolicy policy) {
  return {.topic = std::string(topic),
          .encoding = "cdr",
          .schema_name = ros2_type(MessageType<M>::name()),
          .schema_encoding = "ros2msg",
          .schema = MessageType<M>::ros2_definition(),
          .policy = policy};
}

/// A topic of ours, whose messages are JSON.
[[nodiscard]] inline ViewChannel json_channel(const std::string& name, std::string schema,
                                              SendPolicy policy = SendPolicy::kLatest) {
  return {.topic = "/loopstone/" + name,
          .encoding = "json",
          .schema_name = "loopstone." + name,
          .schema_encoding = "jsonschema",
          .schema = std::move(schema),
          .policy = policy};
}

}  // namespace loopstone
