#pragma once

#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/realism.hpp"

namespace loopstone {

/// The stamps of one sensor's messages. Off: the times themselves.
class StampErrors {
 public:
  StampErrors() = default;
  /// \param latency_s  by which all are late
  /// \param drift      by which its clock runs faster, share
  StampErrors(const RealismStamps& options, double latency_s, double drift, Rng rng);

  /// The stamp of what was measured then [s since the start]. Times grow from call to call, and so
  /// do the stamps.
  [[nodiscard]] double stamp_s(double time_s);

 private:
  RealismStamps options_{};
  double latency_s_ = 0.0;
  double drift_ = 0.0;
  Rng rng_{0};
  double last_s_ = -1e9;
};

/// Messages that do not arrive. Off: none.
class MessageLoss {
 public:
  MessageLoss(const RealismLoss& options, double duration_s, Rng rng);

  [[nodiscard]] bool is_scan_lost(double time_s);
  [[nodiscard]] bool is_odometry_lost(double time_s);
  void note(RealismRecord& record) const;

 private:
  [[nodiscard]] bool is_in_burst(double time_s) const;

  RealismLoss options_;
  Rng scans_;
  Rng odometry_;
  std::vector<RealismSpoil> bursts_{};
};

}  // namespace loopstone
