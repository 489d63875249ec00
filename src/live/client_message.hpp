#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "loopstone/live/playback.hpp"

// What clients of Foxglove's protocol say. Whatever comes, the parsers only read it: what is no
// message is told in words.

namespace loopstone {

struct SubscribeRequest {
  struct One {
    std::uint32_t id = 0;  ///< the client's name for it
    std::uint32_t channel = 0;
  };
  std::vector<One> subscriptions{};
};
struct UnsubscribeRequest {
  std::vector<std::uint32_t> ids{};
};
/// A message of the protocol that this server has no use for.
struct UnsupportedRequest {
  std::string what{};
};
/// No message at all.
struct RefusedRequest {
  std::string reason{};
};
using ClientMessage = std::variant<SubscribeRequest, UnsubscribeRequest, PlaybackControl,
                                   UnsupportedRequest, RefusedRequest>;

/// At once, of subscriptions in one message.
inline constexpr std::size_t kMostSubscriptions = 1000;

/// JSON with "op". Cost: O(length), whatever it is.
[[nodiscard]] ClientMessage parse_client_text(std::string_view text);
/// An opcode and what belongs to it, little-endian.
[[nodiscard]] ClientMessage parse_client_bytes(std::string_view bytes);

}  // namespace loopstone
