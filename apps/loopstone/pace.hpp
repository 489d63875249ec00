#pragma once

#include <chrono>
#include <deque>
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

  /// Returns when a message of that stamp is due; at once when it is late. Stamps that run back are
  /// due at once.
  /// \param go_on  asked now and then while waiting; false ends the wait
  void wait_for(Stamp stamp, const std::function<bool()>& go_on);
  /// The message just waited for is a scan.
  void note_scan() { scans_.push_back(due_); }
  /// The pose of the oldest scan without one is known: how long after that scan was due, and after
  /// the message just waited for, is noted.
  void note_pose();

  [[nodiscard]] PaceFigures figures() const;

 private:
  using Clock = std::chrono::steady_clock;

  double speed_;
  std::optional<Stamp> first_stamp_{};
  Clock::time_point first_time_{};
  Clock::time_point due_{};
  std::deque<Clock::time_point> scans_{};  ///< when each was due, until its pose is known
  std::vector<double> after_arrival_s_{};
  std::vector<double> computing_s_{};
};

}  // namespace loopstone::app
