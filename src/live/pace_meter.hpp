#pragma once

#include <chrono>
#include <optional>

#include "loopstone/base/stamp.hpp"

namespace loopstone {

/// How fast a recording goes by, as a multiple of its own pace.
class PaceMeter {
 public:
  /// Over the last second or so; 0 at first.
  [[nodiscard]] double at(Stamp stamp) {
    const Clock::time_point now = Clock::now();
    if (!begin_) begin_ = {now, stamp};
    const double wall_s = std::chrono::duration<double>(now - begin_->time).count();
    if (wall_s < kOverS) return pace_;
    // Who went back was not going backwards.
    pace_ = stamp < begin_->stamp ? 0.0 : (stamp - begin_->stamp).seconds() / wall_s;
    begin_ = {now, stamp};
    return pace_;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr double kOverS = 1.0;

  struct Begin {
    Clock::time_point time{};
    Stamp stamp{};
  };
  std::optional<Begin> begin_{};
  double pace_ = 0.0;
};

}  // namespace loopstone
