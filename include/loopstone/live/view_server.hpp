#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/live/playback.hpp"
#include "loopstone/live/view_channel.hpp"

namespace loopstone {

/// Where a server listens and whom it lets in.
struct ViewServerOptions {
  std::string name = "loopstone";     ///< what clients show
  std::string address = "127.0.0.1";  ///< of this machine: IPv4 or IPv6, in digits
  std::uint16_t port = 8765;          ///< 0: any that is free
  /// Clients must bring it (`?token=...`); where others than this machine can reach the address
  /// there must be one, of at least 8 characters.
  std::string token{};
  /// "https://app.foxglove.dev": pages of other hosts whose scripts may connect.
  std::vector<std::string> origins{};
  std::optional<PlaybackRange> range{};  ///< there is: clients may play, pause and seek
};

/// What one server may be made to hold and to wait for.
struct ViewServerLimits {
  std::size_t clients = 16;                           ///< WebSockets at once
  std::size_t connections = 64;                       ///< with those that only ask for a page
  std::size_t message_bytes = std::size_t{1} << 16U;  ///< that a client may send
  std::size_t waiting_bytes = std::size_t{32}
                              << 20U;  ///< of a client, of messages that it must get
  std::size_t droppable_bytes = std::size_t{1} << 20U;  ///< of a client, of those that it need not
  double handshake_s = 10.0;
  double idle_s = 60.0;  ///< a client that answers no ping for so long is gone
};

struct HttpAnswer {
  int status = 200;
  std::string type = "application/json";
  std::string body{};
};

/// Shows what a program does to browsers and to Foxglove or Lichtblick, on one port: a page at `/`,
/// `/api/...` as the program answers it, and on every path WebSockets of Foxglove's protocol,
/// version 1.
///
///   ViewServer server({.name = "office"});
///   const ChannelId scans = server.add_channel({.topic = "/scan", ...});
///   server.start();
///   std::printf("%s\n", server.url().c_str());
///   while (drives()) server.publish(scans, stamp, bytes());
///
/// Nobody waits for a client: what a slow one misses is said by the channels' policies. Who comes
/// late gets all of each kChanges channel, and of each kLatest and kDroppable channel the last
/// message, when it subscribes.
///
/// Who gets in: without a token only who calls this machine by a loopback name, so that no foreign
/// name can be led here; with one, who brings it. Scripts of pages only from this server itself, a
/// loopback host or `origins`.
///
/// Threads: all calls from any, at any time; the server has one of its own, which ends with it.
/// Memory: for each client what ViewServerLimits says, and the last message of a channel for all.
class ViewServer {
 public:
  /// Throws UsageError for an address that is none, or one that others can reach without a token.
  explicit ViewServer(const ViewServerOptions& options, const ViewServerLimits& limits = {});
  ~ViewServer();
  ViewServer(const ViewServer&) = delete;
  ViewServer& operator=(const ViewServer&) = delete;

  /// Before start().
  /// \param answer  to GET of a path below /api/; nothing: there is no such thing. Called by the
  ///                server's thread: everybody waits for it.
  void on_get(std::function<std::optional<HttpAnswer>(std::string_view path)> answer);
  /// The same to POST of JSON, which changes something; without it none is taken.
  void on_post(
      std::function<std::optional<HttpAnswer>(std::string_view path, std::string_view body)>
          answer);
  /// Before start(). \param handle  called by the server's thread
  void on_playback(std::function<void(const PlaybackControl&)> handle);

  /// Channels may come before and after start(). Throws UsageError for a topic that there is.
  ChannelId add_channel(ViewChannel channel);
  void publish(ChannelId channel, Stamp stamp, std::string bytes);
  /// The recording's clock, which clients show.
  void set_time(Stamp now);
  /// Told to all clients, and to those that come.
  void set_playback(const PlaybackState& state);

  /// Listens. Throws UsageError when the port is taken or the address is not this machine's. Once.
  void start();
  /// Says good-bye to clients, for some tenths of a second at most, and ends the thread: nothing is
  /// asked of the program any more. The destructor does it, too.
  void stop();
  /// After start().
  [[nodiscard]] std::uint16_t port() const;
  /// "http://127.0.0.1:8765/?token=...", after start().
  [[nodiscard]] std::string url() const;
  /// WebSockets that are open.
  [[nodiscard]] std::size_t clients() const;
  /// Those of them that subscribed to a channel.
  [[nodiscard]] std::size_t subscribers(ChannelId channel) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace loopstone
