#pragma once

#include <optional>

namespace loopstone {

/// How much of a belief to replace by fresh samples when readings are explained worse than they
/// used to be: two averages of the evidence, a slow and a fast one; the share is how far the fast
/// one has fallen below the slow one. The averages are kept as logarithms, so a reading of many
/// beams does not underflow; the share does not change when all likelihoods are scaled. The first
/// reading starts both averages.
/// Source: Thrun, Burgard and Fox 2005, table 8.3, augmented Monte-Carlo localisation.
class AugmentedInjection {
 public:
  /// \param slow_rate  alpha_slow, share of a new reading in the slow average, in (0, fast_rate)
  /// \param fast_rate  alpha_fast, in (slow_rate, 1]
  /// Throws UsageError for other rates.
  AugmentedInjection(double slow_rate, double fast_rate);

  /// Takes the evidence of a reading in and returns the share to inject, in [0, 1). NaN throws
  /// UsageError.
  [[nodiscard]] double share_after(double log_evidence);

  /// Forgets all readings; what follows is measured anew.
  void reset() { averages_.reset(); }

 private:
  struct LogAverages {
    double slow;
    double fast;
  };
  double slow_rate_;
  double fast_rate_;
  std::optional<LogAverages> averages_;
};

}  // namespace loopstone
