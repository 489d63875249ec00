#pragma once

#include <deque>
#include <optional>

#include "loopstone/base/stamp.hpp"
#include "loopstone/sensor/messages.hpp"

namespace loopstone {

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

  template <typename Archive>
  void archive(Archive& a) {
    a(nodes_);
  }

 private:
  struct Node {
    Stamp stamp;
    double rate_rad_s;
    double heading_rad;

    template <typename Archive>
    void archive(Archive& a) {
      a(stamp, rate_rad_s, heading_rad);
    }
  };
  std::deque<Node> nodes_{};
};

}  // namespace loopstone
