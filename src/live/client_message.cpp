#include "live/client_message.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

namespace loopstone {
namespace {

using Json = nlohmann::json;

constexpr int kDeepest = 8;
constexpr std::size_t kMostRequestName = 256;
constexpr double kMostSpeed = 1e6;

/// Deeper than any message; outside of texts brackets are all that nests.
bool nests_too_deep(std::string_view text) {
  int depth = 0;
  bool in_text = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_text) {
      if (c == '\\') ++i;
      if (c == '"') in_text = false;
    } else if (c == '"') {
      in_text = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kDeepest) return true;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return false;
}

std::optional<std::uint32_t> id_of(const Json& value) {
  if (!value.is_number_unsigned()) return {};
  const auto number = value.get<std::uint64_t>();
  if (number > std::numeric_limits<std::uint32_t>::max()) return {};
  return static_cast<std::uint32_t>(number);
}

/// A list below this name, of at most kMostSubscriptions; null when there is none.
const Json* list_of(const Json& message, const char* name) {
  const auto found = message.find(name);
  if (found == message.end() || !found->is_array() || found->size() > kMostSubscriptions)
    return nullptr;
  return &*found;
}

ClientMessage subscribe(const Json& message) {
  const Json* list = list_of(message, "subscriptions");
  if (list == nullptr) return RefusedRequest{"subscribe: a list of subscriptions is missing"};
  SubscribeRequest request;
  for (const Json& one : *list) {
    const auto id = one.is_object() && one.contains("id") ? id_of(one["id"]) : std::nullopt;
    const auto channel =
        one.is_object() && one.contains("channelId") ? id_of(one["channelId"]) : std::nullopt;
    if (!id || !channel)
      return RefusedRequest{"subscribe: a subscription needs id and channelId, both numbers"};
    request.subscriptions.push_back({*id, *channel});
  }
  return request;
}

ClientMessage unsubscribe(const Json& message) {
  const Json* list = list_of(message, "subscriptionIds");
  if (list == nullptr) return RefusedRequest{"unsubscribe: a list of subscriptionIds is missing"};
  UnsubscribeRequest request;
  for (const Json& one : *list) {
    const auto id = id_of(one);
    if (!id) return RefusedRequest{"unsubscribe: a subscriptionId is no number"};
    request.ids.push_back(*id);
  }
  return request;
}

/// Operations of the protocol that need a capability that is not offered here.
constexpr std::array<std::string_view, 9> kUnsupported{
    "advertise",
    "unadvertise",
    "getParameters",
    "setParameters",
    "subscribeParameterUpdates",
    "unsubscribeParameterUpdates",
    "subscribeConnectionGraph",
    "unsubscribeConnectionGraph",
    "fetchAsset",
};

/// Numbers of a message, one after the other, of one that is long enough.
class Fields64 {
 public:
  explicit Fields64(std::string_view bytes) : bytes_(bytes) {}

  template <typename T>
  [[nodiscard]] T next() {
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      const auto byte = static_cast<unsigned char>(bytes_[at_ + i]);
      bits |= std::uint64_t{byte} << (8 * i);
    }
    at_ += sizeof(T);
    if constexpr (std::is_same_v<T, float>) {
      const auto half = static_cast<std::uint32_t>(bits);
      float value = 0.0F;
      std::memcpy(&value, &half, sizeof value);
      return value;
    } else {
      return static_cast<T>(bits);
    }
  }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
};

ClientMessage playback_control(std::string_view bytes) {
  constexpr std::size_t kHead = 1 + 4 + 1 + 8 + 4;
  if (bytes.size() < kHead) return RefusedRequest{"playback control: the message is cut off"};
  Fields64 fields(bytes);
  const auto command = fields.next<std::uint8_t>();
  const double speed = fields.next<float>();
  const auto had_seek = fields.next<std::uint8_t>();
  const auto time = fields.next<std::uint64_t>();
  const auto length = fields.next<std::uint32_t>();
  if (command > 1) return RefusedRequest{"playback control: neither play nor pause"};
  if (!std::isfinite(speed) || speed < 0.0)
    return RefusedRequest{"playback control: the speed must be 0 or more"};
  if (length > kMostRequestName || bytes.size() - kHead != length)
    return RefusedRequest{"playback control: the length of the request's id is wrong"};
  if (time > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()))
    return RefusedRequest{"playback control: no time is so late"};
  PlaybackControl control{.play = command == 0,
                          .speed = std::min(speed, kMostSpeed),
                          .request = std::string(bytes.substr(kHead))};
  if (had_seek != 0) control.seek_to = Stamp{static_cast<std::int64_t>(time)};
  return control;
}

}  // namespace

ClientMessage parse_client_text(std::string_view text) {
  if (nests_too_deep(text)) return RefusedRequest{"the message nests too deep"};
  const Json message = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (message.is_discarded()) return RefusedRequest{"the message is not JSON"};
  if (!message.is_object() || !message.contains("op") || !message["op"].is_string())
    return RefusedRequest{"the message has no op"};
  const auto& op = message["op"].get_ref<const std::string&>();
  if (op == "subscribe") return subscribe(message);
  if (op == "unsubscribe") return unsubscribe(message);
  if (std::ranges::find(kUnsupported, op) != kUnsupported.end()) return UnsupportedRequest{op};
  return RefusedRequest{"there is no op of this name"};
}

ClientMessage parse_client_bytes(std::string_view bytes) {
  if (bytes.empty()) return RefusedRequest{"the message is empty"};
  switch (static_cast<unsigned char>(bytes.front())) {
    case 1:
      return UnsupportedRequest{"messages of clients"};
    case 2:
      return UnsupportedRequest{"calls of services"};
    case 3:
      return playback_control(bytes.substr(1));
    default:
      return RefusedRequest{"there is no such opcode"};
  }
}

}  // namespace loopstone
