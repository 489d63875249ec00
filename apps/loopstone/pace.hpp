#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/report/run_info.hpp"

namespace loopstone::app {

/// Hands out a log's messages when a robot would have: at the log's own pace, or a multiple of it.
class Pace {
 public:
  /// \param speed  1: as recorded
  explicit Pace(double speed) : speed_(speed) {}

  /// Returns when a message of that stamp is due; at once when it is late. Stamps that run back are due at once.
  /// \param go_on  asked now and then while waiting; false ends the wait
  void wait_for(Stamp stamp, const std::function<bool()>& go_on);
  /// The message just waited for led to a pose: how long after it was due is noted.
  void note_done();

  [[nodiscard]] PaceFigures figures() const;

 private:
  using Clock = std::chrono::steady_clock;

  double speed_;
  std::optional<Stamp> first_stamp_{};
  Clock::time_point first_time_{};
  Clock::time_point due_{};
  std::vector<double> latencies_s_{};
};

}  // namespace loopstone::app
