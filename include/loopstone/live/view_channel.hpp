#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "loopstone/base/stamp.hpp"

namespace loopstone {

/// What becomes of a channel's messages where a client takes them more slowly than they come. Who
/// subscribes later gets the last message of all but kEvery.
enum class SendPolicy {
  kEvery,      ///< each is sent; a client that falls too far behind is let go
  kLatest,     ///< the newest one is sent
  kDroppable,  ///< the oldest of those that wait are left out
  kChanges,    ///< each changes a state; who subscribes, or lets too many wait, gets all of it
};

struct ViewMessage {
  Stamp stamp{};
  std::string bytes{};
};

/// A topic, as Foxglove's protocol advertises it.
struct ViewChannel {
  std::string topic{};
  std::string encoding{};  ///< of the messages: "cdr", "json"
  std::string schema_name{};
  std::string schema_encoding{};  ///< "ros2msg", "jsonschema"
  std::string schema{};
  SendPolicy policy = SendPolicy::kEvery;
  /// Of kChanges: one message that is all of the state; nothing while there is none. Called by the
  /// server's thread, while no other one waits for it. It may lock what the publisher locks; a
  /// change is in it before it is published.
  std::function<std::optional<ViewMessage>()> whole{};
};

/// A channel's place in the order in which they were added.
struct ChannelId {
  std::uint32_t index = 0;
  friend constexpr bool operator==(ChannelId, ChannelId) = default;
};

}  // namespace loopstone
