#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/formats/log_reader.hpp"

// Every recorded message has two times: its own stamp, and when the recorder got it. Which to
// believe.

namespace loopstone {

/// What the first messages of a topic tell of both.
class StampFacts {
 public:
  static constexpr std::size_t kMost = 400;

  /// \param own  the header's stamp; nothing for messages without a header
  void add(std::optional<Stamp> own, Stamp recorded);

  [[nodiscard]] std::int64_t count() const { return count_; }
  /// Why the messages' own stamps can't be used; empty when they can.
  [[nodiscard]] std::string fault_of_own() const;
  [[nodiscard]] std::string fault_of_record() const;
  /// Median of recorder less own.
  [[nodiscard]] Duration offset() const;
  /// By how much the differences scatter: the middle half of them.
  [[nodiscard]] Duration scatter() const;
  /// How fast their own clock runs by the recorder's; 1 when it can't be told.
  [[nodiscard]] double speed() const;
  /// What is added to their own stamps to be those of `lead`, which the recorder got at the same
  /// time; nothing when no such moment is known.
  [[nodiscard]] std::optional<Duration> behind(const StampFacts& lead) const;
  /// Usual time from message to message, by the clock that is usable; 0 when it can't be told.
  [[nodiscard]] double period_s() const;

 private:
  [[nodiscard]] std::string fault_of(const std::vector<Stamp>& stamps) const;

  std::vector<Stamp> own_{};
  std::vector<Stamp> recorded_{};
  std::int64_t count_ = 0;
  std::int64_t without_own_ = 0;
};

/// How a topic's messages get the time that they are used with.
struct TopicClock {
  enum class Source { kOwn, kRecord, kOrder };
  Source source = Source::kOwn;
  Duration shift{};     ///< added to it
  double period_s = 0;  ///< of kOrder: made-up stamps lie so far apart

  [[nodiscard]] Stamp time(std::optional<Stamp> own, Stamp recorded) const {
    return (source == Source::kOwn && own ? *own : recorded) + shift;
  }
};

/// The clocks of several topics, so that all tell the same time.
struct ClockChoice {
  std::vector<TopicClock> clocks{};     ///< in the order of the topics
  std::vector<std::string> notes{};     ///< what was measured
  std::vector<std::string> warnings{};  ///< what was wrong
};

/// A topic, as the choice of clocks sees it.
struct ClockQuestion {
  std::string name{};
  const StampFacts* facts = nullptr;
  /// Stamps that may lie ahead on purpose: an offset says nothing about their clock.
  bool is_dated_ahead = false;
};

/// \param topics  the first leads: the others are brought to its clock
[[nodiscard]] ClockChoice choose_clocks(const std::vector<ClockQuestion>& topics, StampUse use);

/// How two clocks run apart over a recording: mean difference at its beginning and at its end.
class ClockDrift {
 public:
  void add(Stamp own, Stamp recorded);
  /// Of recorder less own, from the first to the last messages; nothing for short recordings.
  [[nodiscard]] std::optional<double> drift_s() const;

 private:
  static constexpr std::size_t kMost = 100;
  std::vector<double> first_s_{};
  std::vector<double> last_s_{};  // a ring
  std::int64_t count_ = 0;
};

}  // namespace loopstone
