#pragma once

#include <deque>
#include <string>

#include "loopstone/base/words.hpp"

namespace loopstone {

/// What a filter says of itself.
enum class FilterStatus {
  kConverging,    ///< the belief is still wide, too young to be judged, or doubted a little
  kConverged,     ///< the belief is narrow, and the readings are what it predicts
  kInconsistent,  ///< the readings are not what the belief predicts: the estimate must not be used
};

constexpr auto words_of(FilterStatus /*any*/) {
  using enum FilterStatus;
  return std::array{Word{kConverging, "converging"}, Word{kConverged, "converged"},
                    Word{kInconsistent, "inconsistent"}};
}

/// Why a filter is inconsistent.
enum class FilterDoubt {
  kNone,
  kInnovations,  ///< readings miss their predictions by more than both noises explain
  kEvidence,     ///< readings are far less probable than they would be if the model were right
  /// reading after reading leaves next to no particle: the estimate hangs on single samples
  kEffectiveSampleSize,
};

constexpr auto words_of(FilterDoubt /*any*/) {
  using enum FilterDoubt;
  return std::array{Word{kNone, "none"}, Word{kInnovations, "innovations"},
                    Word{kEvidence, "evidence"},
                    Word{kEffectiveSampleSize, "effective_sample_size"}};
}

/// One reading, compared with what the filter predicted before it.
struct FilterReading {
  double innovation_chi2 = 0.0;  ///< squared Mahalanobis distance of what the reading explained
  int innovation_freedom = 0;    ///< numbers in it
  double log_evidence = 0.0;
  double expected_log_evidence = 0.0;  ///< if model and belief are right
  double log_evidence_variance = 0.0;  ///< of log_evidence about that
  double log_evidence_jump = 0.0;  ///< most that a single one of the things read can take from it
  double effective_share = 1.0;    ///< effective sample size after the reading / particles
};

struct FilterHealthOptions {
  int window = 20;          ///< judged are the last so many readings
  int min_readings = 5;     ///< and none before there are so many
  double z_quantile = 5.0;  ///< normal quantile of the bounds; false alarms become rare with it
  double min_effective_share = 0.01;  ///< geometric mean over the window
};

/// The judgement over a window of readings.
struct FilterHealth {
  FilterDoubt doubt = FilterDoubt::kNone;
  int readings = 0;
  double innovation_ratio = 1.0;        ///< chi2 per degree of freedom; 1 is what is to be expected
  double innovation_ratio_bound = 0.0;  ///< 0 while there are too few readings
  double evidence_deficit = 0.0;        ///< log evidence below what is to be expected
  double evidence_deficit_bound = 0.0;  ///< 0 while there are too few readings
  double effective_share = 1.0;
};

/// "readings miss their predictions: chi2 per degree of freedom 7.2, bound 2.1". Empty without a
/// doubt.
[[nodiscard]] std::string reason(const FilterHealth& health);

/// Watches whether a filter's readings are what it predicts.
/// Source: Bar-Shalom, Li and Kirubarajan 2001, "Estimation with applications to tracking and
/// navigation", section 5.4.2 (normalised innovation squared over a window). The evidence falls in
/// jumps where a reading holds outliers, so its bound is Bernstein's inequality, with the
/// probability exp(-z^2 / 2): Boucheron, Lugosi and Massart 2013, corollary 2.11.
class FilterHealthMonitor {
 public:
  explicit FilterHealthMonitor(const FilterHealthOptions& options = {});

  /// Takes a reading in. Only readings for which the predictions hold belong here: while the belief
  /// is narrow.
  void add(const FilterReading& reading);
  [[nodiscard]] FilterHealth judge() const { return judge(options_.z_quantile); }
  /// With bounds of another normal quantile: lower ones doubt earlier, and more often without need.
  [[nodiscard]] FilterHealth judge(double z_quantile) const;
  void reset() { readings_.clear(); }

 private:
  FilterHealthOptions options_;
  std::deque<FilterReading> readings_;
};

}  // namespace loopstone
