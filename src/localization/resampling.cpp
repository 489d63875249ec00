#include "loopstone/localization/resampling.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "loopstone/base/error.hpp"
#include "loopstone/localization/chi_square.hpp"

namespace loopstone {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The sum of weights that can be drawn from.
double checked_total(std::span<const double> weights) {
  double total = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (!(weights[i] >= 0.0 && weights[i] < kInfinity)) {
      throw UsageError("weight " + std::to_string(i) + " of " + std::to_string(weights.size()) +
                       " is " + std::to_string(weights[i]) +
                       "; weights must be finite and not negative");
    }
    total += weights[i];
  }
  if (!(total > 0.0 && total < kInfinity)) {
    throw UsageError("cannot resample: the weights sum to " + std::to_string(total) +
                     "; at least one must be above zero, and the sum finite");
  }
  return total;
}

/// The indices under the points point(0) <= point(1) <= ... of [0, 1), where each index owns its
/// share of the weights.
template <typename Point>
void append_at_points(std::span<const double> weights, double total, std::size_t count,
                      const Point& point, std::vector<std::size_t>& indices) {
  // Rounding may carry a point past the last sum; it belongs to the last particle that has any
  // weight.
  std::size_t last = weights.size() - 1;
  while (weights[last] <= 0.0) --last;
  std::size_t index = 0;
  double sum = weights[0];
  for (std::size_t k = 0; k < count; ++k) {
    const double at = point(k) * total;
    while (at >= sum && index < last) sum += weights[++index];
    indices.push_back(index);
  }
}

/// `count` sorted uniform numbers in O(count): normalised sums of exponential spacings (Devroye
/// 1986, section V.2.1).
std::vector<double> sorted_uniforms(std::size_t count, Rng& rng) {
  std::vector<double> sums(count);
  double sum = 0.0;
  for (double& value : sums) value = (sum -= std::log(1.0 - rng.uniform()));
  sum -= std::log(1.0 - rng.uniform());
  for (double& value : sums) value /= sum;
  return sums;
}

void append_multinomial(std::span<const double> weights, double total, std::size_t count, Rng& rng,
                        std::vector<std::size_t>& indices) {
  const std::vector<double> points = sorted_uniforms(count, rng);
  append_at_points(
      weights, total, count, [&](std::size_t k) { return points[k]; }, indices);
}

void append_residual(std::span<const double> weights, double total, std::size_t count, Rng& rng,
                     std::vector<std::size_t>& indices) {
  std::vector<double> rests(weights.size());
  double rest_total = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double expected = static_cast<double>(count) * (weights[i] / total);
    const double whole = std::floor(expected);
    rests[i] = expected - whole;
    rest_total += rests[i];
    const std::size_t copies = std::min(static_cast<std::size_t>(whole),
                                        count - indices.size());  // rounding never adds one
    indices.insert(indices.end(), copies, i);
  }
  const std::size_t rest = count - indices.size();
  if (rest == 0) return;
  // Where rounding left a place but no remainder, the weights themselves decide.
  if (rest_total > 0.0) {
    append_multinomial(rests, rest_total, rest, rng, indices);
  } else {
    append_multinomial(weights, total, rest, rng, indices);
  }
  std::inplace_merge(indices.begin(), indices.end() - static_cast<std::ptrdiff_t>(rest),
                     indices.end());
}

}  // namespace

std::vector<std::size_t> resample_indices(ResamplingScheme scheme, std::span<const double> weights,
                                          std::size_t count, Rng& rng) {
  const double total = checked_total(weights);
  std::vector<std::size_t> indices;
  indices.reserve(count);
  const double step = 1.0 / static_cast<double>(count);
  switch (scheme) {
    case ResamplingScheme::kMultinomial:
      append_multinomial(weights, total, count, rng, indices);
      break;
    case ResamplingScheme::kStratified:
      append_at_points(
          weights, total, count,
          [&](std::size_t k) { return (static_cast<double>(k) + rng.uniform()) * step; }, indices);
      break;
    case ResamplingScheme::kSystematic: {
      const double shared = rng.uniform();
      append_at_points(
          weights, total, count,
          [&](std::size_t k) { return (static_cast<double>(k) + shared) * step; }, indices);
      break;
    }
    case ResamplingScheme::kResidual:
      append_residual(weights, total, count, rng, indices);
      break;
  }
  return indices;
}

Resampler resampler_of(ResamplingScheme scheme) {
  return [scheme](std::span<const double> weights, std::size_t count, Rng& rng) {
    return resample_indices(scheme, weights, count, rng);
  };
}

LogWeightSum sum_log_weights(std::span<const double> log_weights) {
  double highest = -kInfinity;
  for (std::size_t i = 0; i < log_weights.size(); ++i) {
    if (!(log_weights[i] < kInfinity)) {
      throw UsageError("log weight " + std::to_string(i) + " of " +
                       std::to_string(log_weights.size()) + " is " +
                       std::to_string(log_weights[i]) + "; it must be finite or -inf");
    }
    highest = std::max(highest, log_weights[i]);
  }
  if (highest == -kInfinity) return {.log_total = -kInfinity, .effective_sample_size = 0.0};
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (const double log_weight : log_weights) {
    const double weight = std::exp(log_weight - highest);
    sum += weight;
    sum_of_squares += weight * weight;
  }
  return {.log_total = highest + std::log(sum),
          .effective_sample_size = sum * sum / sum_of_squares};
}

NormalisedLogWeights normalise_log_weights(std::vector<double> log_weights) {
  const LogWeightSum sum = sum_log_weights(log_weights);
  if (sum.any()) {
    for (double& log_weight : log_weights) log_weight -= sum.log_total;
  }
  return {.log_weights = std::move(log_weights), .sum = sum};
}

std::vector<double> weights_from_log(std::span<const double> log_weights) {
  const LogWeightSum sum = sum_log_weights(log_weights);
  std::vector<double> weights(log_weights.size(), 0.0);
  if (!sum.any()) return weights;
  std::transform(log_weights.begin(), log_weights.end(), weights.begin(),
                 [&](double log_weight) { return std::exp(log_weight - sum.log_total); });
  return weights;
}

double effective_sample_size(std::span<const double> weights) {
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (const double weight : weights) {
    sum += weight;
    sum_of_squares += weight * weight;
  }
  return sum_of_squares > 0.0 ? sum * sum / sum_of_squares : 0.0;
}

std::size_t kld_sample_count(std::size_t bins, double epsilon, double z_quantile) {
  if (!(epsilon > 0.0)) {
    throw UsageError("KLD: epsilon is " + std::to_string(epsilon) + "; it must be above zero");
  }
  if (bins <= 1) return 1;
  const double count =
      chi_square_quantile(static_cast<double>(bins - 1), z_quantile) / (2.0 * epsilon);
  return static_cast<std::size_t>(std::max(1.0, std::ceil(count)));
}

}  // namespace loopstone
