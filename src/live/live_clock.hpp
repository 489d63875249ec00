#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <optional>
#include <string>

#include "loopstone/base/stamp.hpp"

namespace loopstone {

/// The stamps of a source that is read live, made to go on whatever its clock does: a clock that is
/// set, a computer that starts again, a recording that is played once more. Stamps are believed as
/// they are until several in a row say that the clock has jumped; from then on they are shifted, so
/// that they go on where they were, by the time that passed on this machine.
class LiveClock {
 public:
  using Arrival = std::chrono::steady_clock::time_point;

  /// Stamps of a kind that go back by more than this, or ahead by more than that without as much
  /// time passing, are of a clock that jumped, or broken.
  static constexpr Duration kBack{1'000'000'000};
  static constexpr Duration kAhead{60'000'000'000};
  /// So many in a row are believed.
  static constexpr int kEnough = 3;

  /// The stamp that is to be used; nothing: the message can't be used. Of a kind they never go
  /// back.
  /// \param kind  of message, and of laser
  [[nodiscard]] std::optional<Stamp> take(Stamp stamp, std::size_t kind, Arrival arrived);
  /// Once after a jump: by how much the clock went ahead.
  [[nodiscard]] std::optional<Duration> take_jump();

  /// Shifts all that comes by so much more.
  void shift(Duration by) { shift_.nanoseconds += by.nanoseconds; }

 private:
  struct Last {
    Stamp stamp{};  ///< as it is used
    Arrival arrived{};
  };
  /// Stamps that say that the clock has jumped.
  struct Doubt {
    int count = 0;
    Stamp stamp{};
    Arrival arrived{};
  };
  [[nodiscard]] bool has_jumped(Stamp now, std::size_t kind, Arrival arrived) const;
  [[nodiscard]] bool is_believed(Stamp stamp, Arrival arrived);

  Duration shift_{};
  std::map<std::size_t, Stamp> last_of_kind_{};
  std::optional<Last> last_{};  ///< the latest of all kinds
  Doubt doubt_{};
  std::optional<Duration> jump_{};
};

}  // namespace loopstone
