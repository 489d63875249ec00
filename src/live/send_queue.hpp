#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>

#include "live/server_frames.hpp"
#include "loopstone/live/view_channel.hpp"

namespace loopstone {

/// What waits to be sent to one client, by the policies of the channels. Bounded, however slow the
/// client.
///
/// Sources are what frames come from: a subscription, or the server itself.
class SendQueue {
 public:
  struct Limits {
    std::size_t every_bytes = 0;      ///< beyond, the client is overrun
    std::size_t droppable_bytes = 0;  ///< beyond, the oldest go
    std::size_t every_frames = 4096;
    std::size_t droppable_frames = 96;
    /// Of one source; beyond either, all of its state is told instead.
    std::size_t changes = 32;
    std::size_t change_bytes = std::size_t{1} << 20U;
  };
  struct Next {
    std::uint64_t source = 0;
    std::optional<OutFrame> frame{};  ///< nothing: all of the source's state is to be told
  };

  explicit SendQueue(const Limits& limits) : limits_(limits) {}

  void push(std::uint64_t source, SendPolicy policy, OutFrame frame);
  /// All of the source's state is to be told, as it is when its turn comes.
  void push_whole(std::uint64_t source);
  /// Nothing of that source any more.
  void forget(std::uint64_t source);
  [[nodiscard]] std::optional<Next> pop();

  [[nodiscard]] bool empty() const { return items_.empty(); }
  /// More waits of what must not be lost than the client may make us keep: it is lost. Nothing is
  /// kept any more.
  [[nodiscard]] bool is_overrun() const { return is_overrun_; }
  /// How many were left out.
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

 private:
  enum class Kind { kEvery, kLatest, kDroppable, kChange, kWhole };
  struct Item {
    std::uint64_t source;
    Kind kind;
    OutFrame frame;
  };
  using Place = std::list<Item>::iterator;

  struct Amount {
    std::size_t frames = 0;
    std::size_t bytes = 0;
  };

  [[nodiscard]] Place find(std::uint64_t source, Kind kind);
  Place erase(Place place);
  void append(std::uint64_t source, Kind kind, OutFrame frame);
  void add_change(std::uint64_t source, OutFrame frame);
  void drop_oldest();
  [[nodiscard]] Amount* amount_of(Kind kind);

  Limits limits_;
  std::list<Item> items_{};
  Amount every_{};
  Amount droppable_{};
  bool is_overrun_ = false;
  std::uint64_t dropped_ = 0;
};

}  // namespace loopstone
