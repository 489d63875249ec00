#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/live/playback.hpp"
#include "loopstone/live/view_channel.hpp"
#include "loopstone/live/view_server.hpp"

// What the server says in Foxglove's protocol.

namespace loopstone {

/// One message of a WebSocket. What many clients get is shared by them.
struct OutFrame {
  bool is_text = false;
  std::string head{};
  std::shared_ptr<const std::string> body{};  ///< after the head; may be null

  [[nodiscard]] std::size_t size() const { return head.size() + (body ? body->size() : 0); }
};

enum class StatusLevel { kInfo = 0, kWarning = 1, kError = 2 };

[[nodiscard]] OutFrame server_info_frame(const ViewServerOptions& options,
                                         const std::string& session);
/// \param first  the id of the first one
[[nodiscard]] OutFrame advertise_frame(const std::vector<const ViewChannel*>& channels,
                                       std::uint32_t first);
[[nodiscard]] OutFrame status_frame(StatusLevel level, std::string_view text);
[[nodiscard]] OutFrame message_frame(std::uint32_t subscription, Stamp stamp,
                                     std::shared_ptr<const std::string> body);
[[nodiscard]] OutFrame time_frame(Stamp now);
[[nodiscard]] OutFrame playback_frame(const PlaybackState& state);

}  // namespace loopstone
