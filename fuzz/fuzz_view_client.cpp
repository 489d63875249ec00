#include <algorithm>
#include <string>

#include "live/access.hpp"
#include "live/client_message.hpp"
#include "live/view_hub.hpp"
#include "refusal.hpp"

// What a client of the live view may send: the first byte says how. 't': a text message; 'b': a
// binary one; 'u': the target of a request, its host and its origin, a line each. Text and binary
// messages go to a hub with a channel of each kind; what it has to say must be of bounded size.
namespace {

using namespace loopstone;

void tell_hub(std::string_view text, bool is_text) {
  ViewHub hub({.range = PlaybackRange{Stamp{0}, Stamp{1'000'000'000}}}, {}, "session");
  for (const SendPolicy policy :
       {SendPolicy::kEvery, SendPolicy::kLatest, SendPolicy::kDroppable, SendPolicy::kChanges}) {
    hub.add_channel(
        {.topic = "/" + std::to_string(static_cast<int>(policy)), .policy = policy, .whole = [] {
           return ViewMessage{Stamp{1}, "all"};
         }});
  }
  hub.on_playback([&](const PlaybackControl& control) {
    if (!(control.speed >= 0.0) || control.request.size() > 256) __builtin_trap();
    hub.set_playback({.request = control.request});
  });
  const auto client = hub.join([] {});
  if (!client) __builtin_trap();
  for (int twice = 0; twice < 2; ++twice) {
    if (is_text) {
      hub.receive_text(*client, text);
    } else {
      hub.receive_bytes(*client, text);
    }
    for (std::uint32_t channel = 0; channel < 4; ++channel)
      hub.publish({channel}, Stamp{2}, "message");
  }
  std::size_t frames = 0;
  while (hub.next_frame(*client)) ++frames;
  if (frames > 5000) __builtin_trap();
}

void ask_for_access(std::string_view text) {
  const auto line = [&] {
    const auto end = std::min(text.find('\n'), text.size());
    const std::string_view found = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    return std::string(found);
  };
  const auto target = parse_target(line());
  RequestHeads heads{.host = line(), .origin = line()};
  if (target) heads.token = target->token;
  const bool knows_token = heads.token == "correct horse";
  if (!refuse({.token = "correct horse"}, heads) && !knows_token) __builtin_trap();
  if (!refuse({}, heads) && !is_loopback_host(heads.host)) __builtin_trap();
  if (target && parse_target("/?token=" + in_query(heads.token))->token != heads.token)
    __builtin_trap();
  (void)choose_sub_protocol(*heads.origin);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string_view text = fuzz::text_of(data, size);
  if (text.empty()) return -1;
  const char how = text.front();
  text.remove_prefix(1);
  if (how == 'u') {
    ask_for_access(text);
  } else {
    tell_hub(text, how == 't');
  }
  return 0;
}
