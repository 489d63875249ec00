#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <future>
#include <optional>
#include <string>

#include "loopstone/sensor/log_digest.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/slam/session.hpp"

namespace loopstone {

/// Saves a run's state now and then, and puts it back: the run goes on to the same bytes.
///
///   Checkpoint checkpoint({.every_s = 30.0, .write = [&](const Session& s) { ... }}, terms);
///   if (saved) checkpoint.resume(std::move(*saved), mapper, next_message);
///   while (auto message = next_message()) {
///     mapper.add(*message);
///     checkpoint.after(*message, mapper);
///   }
///   checkpoint.after_last(mapper);
///
/// Scans wait while the front end is copied, not while the back end comes as far or the session is
/// written: both happen on other threads.
class Checkpoint {
 public:
  struct How {
    double every_s = 0.0;  ///< at most so often; 0: only after the last message
    /// Keeps a session, all of it or nothing, and returns its bytes. Called from other threads, one
    /// at a time. What it throws is no reason to end the run: see `failed`. Empty: none is kept.
    std::function<std::int64_t(const Session&)> write{};
    /// Told once, until a session is kept again, why none was. May be empty.
    std::function<void(const std::string& reason)> failed{};
    /// CPU time of this process so far [s]. May be empty.
    std::function<double()> cpu_seconds{};
  };
  /// What saving cost.
  struct Cost {
    std::int64_t saved = 0;  ///< times
    std::int64_t bytes = 0;  ///< of the last one
    double blocked_s = 0.0;  ///< that scans waited, all times together
    double longest_s = 0.0;  ///< and once, at most
  };
  using NextMessage = std::function<std::optional<SensorMessage>()>;

  Checkpoint(How how, SessionTerms terms);

  /// Goes on from a session: gives the mapper its state, and reads the messages that led to it.
  /// Throws UsageError when it is of another run or of another log, or damaged; the mapper is of no
  /// use then.
  void resume(Session session, Mapper& mapper, const NextMessage& next);

  /// A message that the mapper has dealt with. Saves when it is time to, and the last time is over
  /// and done.
  void after(const SensorMessage& message, Mapper& mapper);
  /// Saves in any case, and returns when that is kept: no more messages will come, be it the end or
  /// an interruption.
  void after_last(Mapper& mapper);

  [[nodiscard]] const SessionTerms& terms() const { return earlier_.terms; }
  /// Of all messages that the mapper has dealt with.
  [[nodiscard]] const LogDigest& log() const { return log_; }
  /// What runs before this one took for the same result.
  [[nodiscard]] double earlier_wall_s() const { return earlier_.wall_s; }
  [[nodiscard]] double earlier_cpu_s() const { return earlier_.cpu_s; }
  /// After after_last().
  [[nodiscard]] const Cost& cost() const { return cost_; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Earlier {
    SessionTerms terms{};
    double wall_s = 0.0;
    double cpu_s = 0.0;
  };

  void save(Mapper& mapper);
  /// Hears how the last writing ended.
  void settle();
  [[nodiscard]] double now_s() const;

  How how_;
  Earlier earlier_;
  LogDigest log_{};
  Clock::time_point started_ = Clock::now();
  double last_s_ = 0.0;
  std::future<std::int64_t> writing_{};  ///< bytes written
  bool told_ = false;
  Cost cost_{};
};

}  // namespace loopstone
