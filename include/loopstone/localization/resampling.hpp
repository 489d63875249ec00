#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/base/words.hpp"

namespace loopstone {

/// How particles are drawn anew in proportion to their weights. All are unbiased: the expected
/// number of copies of particle i is count * w_i. They differ in how far the copies scatter around
/// that.
/// Source: Douc, Cappe and Moulines 2005, "Comparison of resampling schemes for particle
/// filtering".
enum class ResamplingScheme {
  kMultinomial,  ///< independent draws; scatters most
  kStratified,   ///< one draw in each of `count` equal strata; within 2 of the expected copies
  kSystematic,   ///< one draw shared by all strata; floor or ceil of the expected copies
  kResidual,  ///< floor of the expected copies, the rest by multinomial draws (Liu and Chen 1998)
};

constexpr auto words_of(ResamplingScheme /*any*/) {
  using enum ResamplingScheme;
  return std::array{Word{kSystematic, "systematic"}, Word{kStratified, "stratified"},
                    Word{kResidual, "residual"}, Word{kMultinomial, "multinomial"}};
}

/// `count` indices into `weights`, ascending, drawn in proportion to the weights.
/// Weights need not sum to one. Throws UsageError where one is negative, infinite or NaN, or where
/// all are zero. A weight of zero is never drawn. Cost: O(weights + count).
[[nodiscard]] std::vector<std::size_t> resample_indices(ResamplingScheme scheme,
                                                        std::span<const double> weights,
                                                        std::size_t count, Rng& rng);

/// Any way to draw `count` indices in proportion to weights; what a filter asks for.
using Resampler = std::function<std::vector<std::size_t>(std::span<const double> weights,
                                                         std::size_t count, Rng&)>;

[[nodiscard]] Resampler resampler_of(ResamplingScheme scheme);

/// What one pass over logarithms of weights tells.
struct LogWeightSum {
  double log_total = 0.0;  ///< log of the sum of weights; -inf when every weight is zero
  double effective_sample_size = 0.0;  ///< [1, weights], or 0 when every weight is zero
  [[nodiscard]] bool any() const {
    return effective_sample_size > 0.0;
  }  ///< is a weight above zero
};

/// Without overflow or underflow, whatever the weights' scale. Throws UsageError where one is NaN
/// or +inf.
[[nodiscard]] LogWeightSum sum_log_weights(std::span<const double> log_weights);

/// Logarithms of weights that sum to one, and what they summed to before.
struct NormalisedLogWeights {
  std::vector<double> log_weights;
  LogWeightSum sum;  ///< of the weights given; where !sum.any() they are returned as they came
};

[[nodiscard]] NormalisedLogWeights normalise_log_weights(std::vector<double> log_weights);

/// The weights themselves, summing to one; all zero when every logarithm is -inf.
[[nodiscard]] std::vector<double> weights_from_log(std::span<const double> log_weights);

/// How many equally weighted samples would estimate as well: (sum w)^2 / sum w^2. 0 when all
/// weights are zero.
/// Source: Kong, Liu and Wong 1994, "Sequential imputations and Bayesian missing data problems".
[[nodiscard]] double effective_sample_size(std::span<const double> weights);

/// Samples that hold the Kullback-Leibler distance to a histogram of `bins` occupied bins within
/// `epsilon`, with the probability that belongs to the quantile z of the standard normal
/// distribution (2.326 for 99 %). At least 1.
/// Source: Fox 2003, "Adapting the sample size in particle filters through KLD-sampling", eq. 7
/// (Wilson-Hilferty).
[[nodiscard]] std::size_t kld_sample_count(std::size_t bins, double epsilon, double z_quantile);

}  // namespace loopstone
