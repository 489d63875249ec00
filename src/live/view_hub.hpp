#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "live/client_message.hpp"
#include "live/send_queue.hpp"
#include "loopstone/live/playback.hpp"
#include "loopstone/live/view_channel.hpp"
#include "loopstone/live/view_server.hpp"

namespace loopstone {

/// Who subscribed to what, and what waits for whom: all of the server but its sockets. Safe to be
/// called from any thread.
class ViewHub {
 public:
  using Client = std::uint64_t;

  ViewHub(const ViewServerOptions& options, const ViewServerLimits& limits, std::string session);

  /// Before the first client. \param handle  called by receive_bytes()
  void on_playback(std::function<void(const PlaybackControl&)> handle);

  ChannelId add_channel(ViewChannel channel);
  void publish(ChannelId id, Stamp stamp, std::string bytes);
  void set_time(Stamp now);
  void set_playback(const PlaybackState& state);

  /// Somebody came; nothing when too many are there.
  /// \param wake  called whenever something waits for it, maybe by another thread, while others
  ///              wait: it must not call back
  [[nodiscard]] std::optional<Client> join(std::function<void()> wake);
  void leave(Client client);
  [[nodiscard]] std::size_t clients() const;
  [[nodiscard]] std::size_t subscribers(ChannelId channel) const;

  void receive_text(Client client, std::string_view text);
  void receive_bytes(Client client, std::string_view bytes);

  /// What is to be sent next.
  [[nodiscard]] std::optional<OutFrame> next_frame(Client client);
  /// It let too much wait: nothing is kept for it any more.
  [[nodiscard]] bool is_overrun(Client client) const;

 private:
  /// Sources of frames that are no subscriptions, whose ids have 32 bits.
  static constexpr std::uint64_t kServer = std::uint64_t{1} << 32U;
  static constexpr std::uint64_t kClock = kServer + 1;
  /// Of one client.
  static constexpr std::size_t kMostSubscribed = 1000;

  struct Channel {
    ViewChannel about;
    Stamp last_stamp{};
    std::shared_ptr<const std::string> last{};  ///< of kLatest and kDroppable
  };
  struct Member {
    std::function<void()> wake;
    SendQueue queue;
    std::map<std::uint32_t, std::uint32_t> channel_of{};  ///< by the subscription's id
  };

  void take(Client client, ClientMessage message);
  void subscribe(Member& member, const SubscribeRequest& request);
  static void unsubscribe(Member& member, const UnsubscribeRequest& request);
  static void send(Member& member, std::uint64_t source, SendPolicy policy, OutFrame frame);
  static void tell(Member& member, StatusLevel level, std::string_view text);
  [[nodiscard]] std::optional<OutFrame> whole_of(std::uint32_t subscription,
                                                 const ViewChannel& about) const;

  ViewServerOptions options_;
  SendQueue::Limits queue_limits_;
  std::size_t most_clients_;
  std::string session_;
  std::function<void(const PlaybackControl&)> handle_playback_{};

  mutable std::mutex mutex_{};
  std::vector<std::unique_ptr<Channel>> channels_{};  ///< never taken out, so they may be held
  std::map<Client, Member> members_{};
  Client next_client_ = 1;
  std::optional<PlaybackState> playback_{};
  std::optional<Stamp> now_{};
};

}  // namespace loopstone
