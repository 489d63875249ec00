#include "live/view_hub.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include "loopstone/base/error.hpp"

namespace loopstone {

ViewHub::ViewHub(const ViewServerOptions& options, const ViewServerLimits& limits,
                 std::string session)
    : options_(options),
      queue_limits_{.every_bytes = limits.waiting_bytes, .droppable_bytes = limits.droppable_bytes},
      most_clients_(limits.clients),
      session_(std::move(session)) {}

void ViewHub::on_playback(std::function<void(const PlaybackControl&)> handle) {
  handle_playback_ = std::move(handle);
}

void ViewHub::send(Member& member, std::uint64_t source, SendPolicy policy, OutFrame frame) {
  member.queue.push(source, policy, std::move(frame));
  member.wake();
}

void ViewHub::tell(Member& member, StatusLevel level, std::string_view text) {
  send(member, kServer, SendPolicy::kEvery, status_frame(level, text));
}

ChannelId ViewHub::add_channel(ViewChannel channel) {
  const std::scoped_lock lock(mutex_);
  for (const auto& known : channels_) {
    if (known->about.topic == channel.topic)
      throw UsageError("there is a channel " + channel.topic + " already");
  }
  const ChannelId id{static_cast<std::uint32_t>(channels_.size())};
  channels_.push_back(std::make_unique<Channel>(Channel{std::move(channel)}));
  const OutFrame frame = advertise_frame({&channels_.back()->about}, id.index);
  for (auto& [client, member] : members_) send(member, kServer, SendPolicy::kEvery, frame);
  return id;
}

void ViewHub::publish(ChannelId id, Stamp stamp, std::string bytes) {
  const auto body = std::make_shared<const std::string>(std::move(bytes));
  const std::scoped_lock lock(mutex_);
  Channel& channel = *channels_.at(id.index);
  const SendPolicy policy = channel.about.policy;
  if (policy == SendPolicy::kLatest || policy == SendPolicy::kDroppable) {
    channel.last_stamp = stamp;
    channel.last = body;
  }
  for (auto& [client, member] : members_) {
    for (const auto& [subscription, channel_index] : member.channel_of) {
      if (channel_index == id.index)
        send(member, subscription, policy, message_frame(subscription, stamp, body));
    }
  }
}

void ViewHub::set_time(Stamp now) {
  const std::scoped_lock lock(mutex_);
  now_ = now;
  for (auto& [client, member] : members_)
    send(member, kClock, SendPolicy::kLatest, time_frame(now));
}

void ViewHub::set_playback(const PlaybackState& state) {
  const std::scoped_lock lock(mutex_);
  playback_ = state;
  // Who comes later did not ask, and is nowhere yet.
  playback_->request.clear();
  playback_->did_seek = false;
  if (!options_.range) return;
  const OutFrame frame = playback_frame(state);
  for (auto& [client, member] : members_) send(member, kServer, SendPolicy::kEvery, frame);
}

std::optional<ViewHub::Client> ViewHub::join(std::function<void()> wake) {
  const std::scoped_lock lock(mutex_);
  if (members_.size() >= most_clients_) return {};
  const Client client = next_client_++;
  Member& member =
      members_.try_emplace(client, Member{std::move(wake), SendQueue(queue_limits_)}).first->second;
  send(member, kServer, SendPolicy::kEvery, server_info_frame(options_, session_));
  std::vector<const ViewChannel*> channels;
  for (const auto& channel : channels_) channels.push_back(&channel->about);
  if (!channels.empty()) send(member, kServer, SendPolicy::kEvery, advertise_frame(channels, 0));
  if (now_) send(member, kClock, SendPolicy::kLatest, time_frame(*now_));
  if (playback_ && options_.range)
    send(member, kServer, SendPolicy::kEvery, playback_frame(*playback_));
  return client;
}

void ViewHub::leave(Client client) {
  const std::scoped_lock lock(mutex_);
  members_.erase(client);
}

std::size_t ViewHub::clients() const {
  const std::scoped_lock lock(mutex_);
  return members_.size();
}

std::size_t ViewHub::subscribers(ChannelId channel) const {
  const std::scoped_lock lock(mutex_);
  return static_cast<std::size_t>(std::ranges::count_if(members_, [&](const auto& named) {
    return std::ranges::any_of(named.second.channel_of,
                               [&](const auto& wish) { return wish.second == channel.index; });
  }));
}

void ViewHub::receive_text(Client client, std::string_view text) {
  take(client, parse_client_text(text));
}

void ViewHub::receive_bytes(Client client, std::string_view bytes) {
  take(client, parse_client_bytes(bytes));
}

void ViewHub::take(Client client, ClientMessage message) {
  const auto* control = std::get_if<PlaybackControl>(&message);
  if (control != nullptr && options_.range && handle_playback_) return handle_playback_(*control);
  const std::scoped_lock lock(mutex_);
  const auto found = members_.find(client);
  if (found == members_.end()) return;
  Member& member = found->second;
  if (control != nullptr) {
    tell(member, StatusLevel::kWarning, "there is nothing to play here");
  } else if (const auto* wish = std::get_if<SubscribeRequest>(&message)) {
    subscribe(member, *wish);
  } else if (const auto* end = std::get_if<UnsubscribeRequest>(&message)) {
    unsubscribe(member, *end);
  } else if (const auto* unsupported = std::get_if<UnsupportedRequest>(&message)) {
    tell(member, StatusLevel::kWarning, "this server does not offer: " + unsupported->what);
  } else if (const auto* refused = std::get_if<RefusedRequest>(&message)) {
    tell(member, StatusLevel::kError, refused->reason);
  }
}

void ViewHub::subscribe(Member& member, const SubscribeRequest& request) {
  for (const SubscribeRequest::One& one : request.subscriptions) {
    if (one.channel >= channels_.size()) {
      tell(member, StatusLevel::kError,
           "there is no channel " + std::to_string(one.channel) + " to subscribe to");
      continue;
    }
    if (member.channel_of.contains(one.id)) {
      tell(member, StatusLevel::kError,
           "there is a subscription " + std::to_string(one.id) + " already");
      continue;
    }
    if (member.channel_of.size() >= kMostSubscribed) {
      tell(member, StatusLevel::kError, "there are too many subscriptions");
      return;
    }
    member.channel_of[one.id] = one.channel;
    const Channel& channel = *channels_[one.channel];
    if (channel.last) {
      send(member, one.id, channel.about.policy,
           message_frame(one.id, channel.last_stamp, channel.last));
    }
    if (channel.about.policy == SendPolicy::kChanges && channel.about.whole) {
      member.queue.push_whole(one.id);
      member.wake();
    }
  }
}

void ViewHub::unsubscribe(Member& member, const UnsubscribeRequest& request) {
  for (const std::uint32_t id : request.ids) {
    if (member.channel_of.erase(id) == 0) {
      tell(member, StatusLevel::kWarning,
           "there is no subscription " + std::to_string(id) + " to end");
      continue;
    }
    member.queue.forget(id);
  }
}

std::optional<OutFrame> ViewHub::next_frame(Client client) {
  while (true) {
    const Channel* channel = nullptr;
    std::uint32_t subscription = 0;
    {
      const std::scoped_lock lock(mutex_);
      const auto found = members_.find(client);
      if (found == members_.end()) return {};
      auto next = found->second.queue.pop();
      if (!next) return {};
      if (next->frame) return std::move(next->frame);
      subscription = static_cast<std::uint32_t>(next->source);
      channel = channels_[found->second.channel_of.at(subscription)].get();
    }
    // Not under the lock: whoever publishes may hold what this waits for.
    if (auto frame = whole_of(subscription, channel->about)) return frame;
  }
}

std::optional<OutFrame> ViewHub::whole_of(std::uint32_t subscription,
                                          const ViewChannel& about) const {
  if (!about.whole) return {};
  auto message = about.whole();
  if (!message) return {};
  return message_frame(subscription, message->stamp,
                       std::make_shared<const std::string>(std::move(message->bytes)));
}

bool ViewHub::is_overrun(Client client) const {
  const std::scoped_lock lock(mutex_);
  const auto found = members_.find(client);
  return found != members_.end() && found->second.queue.is_overrun();
}

}  // namespace loopstone
