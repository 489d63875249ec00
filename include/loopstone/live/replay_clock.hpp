#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "loopstone/base/stamp.hpp"
#include "loopstone/live/playback.hpp"

namespace loopstone {

/// The clock of a recording that clients play, pause and seek in.
///
///   ReplayClock clock(range, speed, [&](const auto& state) { server.set_playback(state); });
///   server.on_playback([&](const PlaybackControl& control) { clock.control(control); });
///   while (true) {
///     switch (clock.wait_for(next_stamp, go_on)) { ... }
///   }
///
/// Whoever plays hands out everything up to where a client wants to be, as fast as it can; to get
/// back, from the beginning or from wherever it can. A player that is late is not hurried
/// afterwards. control() may be called by any thread, the others by one.
class ReplayClock {
 public:
  enum class Turn {
    kGoOn,      ///< it is due
    kSeekBack,  ///< somebody wants to be before it: at goal()
    kStopped,   ///< `go_on` said no
  };

  /// \param speed  0: as fast as it goes
  /// \param tell   the state, whenever it changes; called by whoever changes it
  ReplayClock(PlaybackRange range, double speed, std::function<void(const PlaybackState&)> tell);
  ~ReplayClock();
  ReplayClock(const ReplayClock&) = delete;
  ReplayClock& operator=(const ReplayClock&) = delete;

  void control(const PlaybackControl& control);

  /// Waits until something of that stamp is due. After kSeekBack the stamps begin anew.
  /// \param go_on  asked several times a second while it waits
  [[nodiscard]] Turn wait_for(Stamp stamp, const std::function<bool()>& go_on);
  /// The recording is at its end: waits until somebody wants to be elsewhere.
  [[nodiscard]] Turn wait_at_end(const std::function<bool()>& go_on);

  /// Where somebody wants to be who is not there yet.
  [[nodiscard]] std::optional<Stamp> goal() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace loopstone
