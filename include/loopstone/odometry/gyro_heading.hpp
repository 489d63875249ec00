#pragma once

#include <deque>
#include <optional>

#include "loopstone/base/stamp.hpp"
#include "loopstone/sensor/messages.hpp"

namespace loopstone {

/// What a heading of a gyro alone is followed by.
struct GyroHeadingNumbers {
  int memory_ms = 10000;
  int largest_gap_ms = 200;
  int hold_ms = 50;
};
inline constexpr GyroHeadingNumbers kGyroHeading{};

template <typename Visitor>
void visit_numbers(const GyroHeadingNumbers& n, Visitor&& visit) {
  visit("memory_ms", n.memory_ms, "chosen: older samples are forgotten; no scan waits so long");
  visit("largest_gap_ms", n.largest_gap_ms,
        "chosen: across a longer gap the rate between is unknown");
  visit("hold_ms", n.hold_ms, "chosen: so long after the newest sample its rate is taken to go on");
}

/// The heading of a robot of which only the gyro is known: its rate, integrated between samples as
/// if it changed linearly. The bias stays in it, a few milliradians from one scan to the next;
/// nothing says when the robot stands still. Memory is bounded: what is older than about 10 s is
/// forgotten.
class GyroHeading {
 public:
  /// Samples that are not newer than the last, or not finite, are ignored. Across a gap of more
  /// than 0.2 s the heading is unknown: it starts anew.
  void add(const ImuSample& sample);

  /// Heading since some start [rad], not wrapped, between samples and up to 0.05 s after the
  /// newest; otherwise nothing.
  [[nodiscard]] std::optional<double> heading_at(Stamp stamp) const;

  [[nodiscard]] std::optional<Stamp> newest() const;

  struct Node {
    Stamp stamp{};
    double rate_rad_s = 0.0;
    double heading_rad = 0.0;

    template <typename Archive>
    void archive(Archive& a) {
      a(stamp, rate_rad_s, heading_rad);
    }
  };
  /// The samples that are remembered.
  struct State {
    std::deque<Node> nodes{};  ///< stamps increase

    template <typename Archive>
    void archive(Archive& a) {
      a(nodes);
    }
  };

  [[nodiscard]] const State& state() const { return state_; }
  /// Throws UsageError when its samples can't have been remembered.
  void restore(State state);

 private:
  State state_{};
};

}  // namespace loopstone
