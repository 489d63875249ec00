#include "live/server_frames.hpp"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

namespace loopstone {
namespace {

using Json = nlohmann::ordered_json;

OutFrame text_frame(const Json& message) {
  // Names need not be UTF-8; JSON must.
  return {.is_text = true, .head = message.dump(-1, ' ', false, Json::error_handler_t::replace)};
}

template <typename T>
void append(std::string& bytes, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i)
    bytes += static_cast<char>((value >> (8 * i)) & 0xFFU);
}

/// The protocol has no time before 1970.
std::uint64_t nanoseconds_of(Stamp stamp) {
  return static_cast<std::uint64_t>(std::max<std::int64_t>(stamp.nanoseconds, 0));
}

Json time_json(Stamp stamp) {
  constexpr std::uint64_t kPerSecond = 1'000'000'000;
  const std::uint64_t nanoseconds = nanoseconds_of(stamp);
  return {{"sec", nanoseconds / kPerSecond}, {"nsec", nanoseconds % kPerSecond}};
}

}  // namespace

OutFrame server_info_frame(const ViewServerOptions& options, const std::string& session) {
  Json info = {{"op", "serverInfo"}, {"name", options.name}, {"capabilities", {"time"}}};
  info["supportedEncodings"] = Json::array();
  info["metadata"] = {{"program", "loopstone"}};
  info["sessionId"] = session;
  if (options.range) {
    info["capabilities"].push_back("playbackControl");
    info["dataStartTime"] = time_json(options.range->start);
    info["dataEndTime"] = time_json(options.range->end);
  }
  return text_frame(info);
}

OutFrame advertise_frame(const std::vector<const ViewChannel*>& channels, std::uint32_t first) {
  Json list = Json::array();
  for (const ViewChannel* channel : channels) {
    list.push_back({{"id", first++},
                    {"topic", channel->topic},
                    {"encoding", channel->encoding},
                    {"schemaName", channel->schema_name},
                    {"schemaEncoding", channel->schema_encoding},
                    {"schema", channel->schema}});
  }
  return text_frame({{"op", "advertise"}, {"channels", std::move(list)}});
}

OutFrame status_frame(StatusLevel level, std::string_view text) {
  return text_frame({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", text}});
}

OutFrame message_frame(std::uint32_t subscription, Stamp stamp,
                       std::shared_ptr<const std::string> body) {
  OutFrame frame{.head = "\x01", .body = std::move(body)};
  append(frame.head, subscription);
  append(frame.head, nanoseconds_of(stamp));
  return frame;
}

OutFrame time_frame(Stamp now) {
  OutFrame frame{.head = "\x02"};
  append(frame.head, nanoseconds_of(now));
  return frame;
}

OutFrame playback_frame(const PlaybackState& state) {
  OutFrame frame{.head = "\x05"};
  append(frame.head, static_cast<std::uint8_t>(state.status));
  append(frame.head, nanoseconds_of(state.now));
  const auto speed = static_cast<float>(state.speed);
  std::uint32_t bits = 0;
  std::memcpy(&bits, &speed, sizeof bits);
  append(frame.head, bits);
  append(frame.head, static_cast<std::uint8_t>(state.did_seek ? 1 : 0));
  append(frame.head, static_cast<std::uint32_t>(state.request.size()));
  frame.head += state.request;
  return frame;
}

}  // namespace loopstone
