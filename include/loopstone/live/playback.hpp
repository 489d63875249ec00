#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "loopstone/base/stamp.hpp"

namespace loopstone {

/// What a client asks of a recording that is played.
struct PlaybackControl {
  bool play = true;    ///< false: it pauses
  double speed = 1.0;  ///< of the recording's own pace; 0: as fast as it goes
  std::optional<Stamp> seek_to{};
  std::string request{};  ///< the client's name for it, for the answer
};

/// As the protocol numbers it.
enum class PlaybackStatus : std::uint8_t {
  kPlaying = 0,
  kPaused = 1,
  kBuffering = 2,  ///< on its way to where somebody wants to be
  kEnded = 3,
};

struct PlaybackState {
  PlaybackStatus status = PlaybackStatus::kPlaying;
  Stamp now{};
  double speed = 1.0;
  bool did_seek = false;  ///< what clients were told before is of another time
  std::string request{};  ///< that this answers; empty: none

  friend bool operator==(const PlaybackState&, const PlaybackState&) = default;
};

/// What can be played.
struct PlaybackRange {
  Stamp start{};
  Stamp end{};
};

}  // namespace loopstone
