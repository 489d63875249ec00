#pragma once

#include <chrono>
#include <optional>

namespace loopstone {

/// Says when something that is repeated is due, by the wall's clock.
class Timer {
 public:
  explicit Timer(double period_s) : period_s_(period_s) {}
  /// Whether its time has come; it then begins anew.
  [[nodiscard]] bool is_due() {
    const Clock::time_point now = Clock::now();
    if (last_ && std::chrono::duration<double>(now - *last_).count() < period_s_) return false;
    last_ = now;
    return true;
  }
  void begin_anew() { last_.reset(); }
  void set_period(double period_s) { period_s_ = period_s; }

 private:
  using Clock = std::chrono::steady_clock;

  double period_s_;
  std::optional<Clock::time_point> last_{};
};

}  // namespace loopstone
