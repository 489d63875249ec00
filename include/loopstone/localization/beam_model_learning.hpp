#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "loopstone/localization/beam_model.hpp"

namespace loopstone {

/// What a beam measured, and what the map says from the pose where it was measured.
struct RangePair {
  double measured_m = 0.0;  ///< +inf: no return; NaN: bad, left out
  double expected_m = 0.0;  ///< +inf: nothing within the greatest range
};

struct BeamLearningOptions {
  int max_iterations = 200;
  double tolerance = 1e-7;             ///< stop when the mean log-likelihood grows by less [nats]
  double sigma_min_m = 0.002;          ///< ranges come in steps of a millimetre or more
  double short_rate_min_per_m = 0.01;  ///< of things in the way
  double short_rate_max_per_m = 20.0;
};

enum class BeamLearningStatus {
  kConverged,
  kIterationLimit,
  kTooFewPairs,  ///< fewer than 10 usable pairs: the mixture is the one given
};

struct BeamLearningResult {
  BeamMixture mixture{};
  BeamLearningStatus status = BeamLearningStatus::kTooFewPairs;
  std::int64_t pairs_used = 0;
  int iterations = 0;
  /// Mean log-likelihood of a pair before each step and after the last; never falls.
  std::vector<double> mean_log_likelihood{};
};

/// Learns the mixture from data by expectation maximisation: the mixture under which the measured
/// ranges are most likely, reached from `initial` (a local maximum; a part that starts with weight
/// 0 stays without).
///
/// Thrun's learn_intrinsic_parameters (table 6.2), with its closed-form steps for weights, sigma
/// and rate, but for this: those of sigma and rate leave out that the parts are cut off (at 0, R
/// and e) and normalised again, so there the likelihood may fall. Here both are maximised with the
/// normalisers, by a search in one dimension, and kept only when they raise the expected
/// likelihood; so every step raises the likelihood. "No return" is a value of its own (+inf): it is
/// explained by the max part, and by the hit part where the map shows nothing.
/// Cost: about 0.1 us a pair and iteration.
/// Throws UsageError for an initial mixture that BeamModel would reject, or a greatest range that
/// is not positive.
[[nodiscard]] BeamLearningResult learn_beam_mixture(std::span<const RangePair> pairs,
                                                    double max_range_m,
                                                    const BeamMixture& initial = {},
                                                    const BeamLearningOptions& options = {});

/// Pairs of one scan whose pose is known.
[[nodiscard]] std::vector<RangePair> range_pairs(const RayCaster& caster, const Pose2& map_T_robot,
                                                 const RangeBeams& beams);

}  // namespace loopstone
