#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "loopstone/localization/localization_result.hpp"

namespace loopstone {

/// Keeps the belief at some moments of a run.
class BeliefSnapshots {
 public:
  /// \param distance_m  travel between two; 0: twelve to twenty-four over the whole run, however
  ///                    long it will be
  explicit BeliefSnapshots(double distance_m) : distance_m_(distance_m) {}

  [[nodiscard]] bool due(double travelled_m) const { return travelled_m >= next_m_; }

  void add(BeliefSnapshot snapshot, double travelled_m) {
    snapshots_.push_back(std::move(snapshot));
    if (distance_m_ <= 0.0 && snapshots_.size() == kMost) {
      // Every other one goes when there are too many.
      for (std::size_t i = 0; i < kMost / 2; ++i) snapshots_[i] = std::move(snapshots_[2 * i]);
      snapshots_.resize(kMost / 2);
      interval_m_ *= 2.0;
    }
    next_m_ = travelled_m + (distance_m_ > 0.0 ? distance_m_ : interval_m_);
  }

  [[nodiscard]] std::vector<BeliefSnapshot> take() { return std::move(snapshots_); }

 private:
  static constexpr std::size_t kMost = 24;
  double distance_m_;
  double interval_m_ = 0.25;
  double next_m_ = 0.0;
  std::vector<BeliefSnapshot> snapshots_{};
};

}  // namespace loopstone
