#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/parallel_for.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/localization/resampling.hpp"

namespace loopstone {

/// A belief over states, held as weighted samples: the particle filter. It knows nothing of motion,
/// sensors or resampling; each verb takes a callable that does. Weights are logarithms and always
/// sum to one; what a reading did to their sum is returned as its evidence, so filters can be
/// weighed against each other (Vermaak, Doucet and Perez 2003, "Maintaining multi-modality through
/// mixture tracking").
///
///   filter.predict(
///       [&](const Pose2& pose, Rng& noise) { return pose * sample(motion, noise); }, rng);
///   const double log_evidence =
///       filter.update([&](const Pose2& pose) { return log_likelihood(scan, map, pose); });
///   if (filter.effective_sample_size() < 0.5 * filter.size())
///     filter.resample(filter.size(), resampler, rng);
///
/// Callables may run on several threads at once. Noise and work are dealt out in chunks of a fixed
/// size, so the result is the same for any number of threads.
/// Source: Thrun, Burgard and Fox 2005, "Probabilistic Robotics", table 4.3; Gordon, Salmond and
/// Smith 1993.
template <typename State>
class ParticleFilter {
 public:
  /// Particles that one callable, with one stream of noise, works on in a row.
  static constexpr std::size_t kChunk = 256;

  /// Equally weighted particles. Throws UsageError without any.
  explicit ParticleFilter(std::vector<State> states)
      : states_(std::move(states)), log_weights_(states_.size()) {
    if (states_.empty()) throw UsageError("a particle filter needs at least one particle");
    weigh_equally();
  }

  /// Weights as logarithms, on any scale. Throws UsageError where sizes differ, a weight is NaN or
  /// +inf, or all are zero.
  ParticleFilter(std::vector<State> states, std::vector<double> log_weights)
      : states_(std::move(states)), log_weights_(log_weights.size(), 0.0) {
    if (states_.empty() || states_.size() != log_weights.size()) {
      throw UsageError("a particle filter needs at least one particle, and one weight for each");
    }
    if (reweight(log_weights) == -std::numeric_limits<double>::infinity()) {
      throw UsageError("a particle filter needs a particle whose weight is not zero");
    }
  }

  [[nodiscard]] std::size_t size() const { return states_.size(); }
  [[nodiscard]] std::span<const State> states() const { return states_; }
  /// Their exponentials sum to one. -inf: ruled out.
  [[nodiscard]] std::span<const double> log_weights() const { return log_weights_; }
  [[nodiscard]] std::vector<double> weights() const {
    std::vector<double> weights(size());
    std::transform(log_weights_.begin(), log_weights_.end(), weights.begin(),
                   [](double log_weight) { return std::exp(log_weight); });
    return weights;
  }
  /// [1, size()]: see loopstone::effective_sample_size.
  [[nodiscard]] double effective_sample_size() const { return effective_sample_size_; }

  /// Moves every particle by a draw from the motion model, which is either of
  ///   motion(const State& before, Rng& noise) -> State
  ///   motion(std::span<State> states, Rng& noise)         in place, at most kChunk at once
  /// Takes one number from rng, whatever the motion model draws.
  template <typename Motion>
  void predict(const Motion& motion, Rng& rng, Threads threads = {1}) {
    const Rng streams(rng());
    for_each_chunk(threads, [&](std::size_t chunk, std::size_t begin, std::size_t count) {
      Rng noise = streams.fork(chunk);
      const std::span<State> states = std::span<State>(states_).subspan(begin, count);
      if constexpr (std::invocable<const Motion&, std::span<State>, Rng&>) {
        motion(states, noise);
      } else {
        for (State& state : states) state = motion(std::as_const(state), noise);
      }
    });
  }

  /// Weighs every particle by how well it explains a reading; the sensor model is either of
  ///   sensor(const State&) -> double log p(reading | state)
  ///   sensor(std::span<const State>, std::span<double> log_likelihoods) at most kChunk at once
  /// Returns and throws as reweight does.
  template <typename Sensor>
  double update(const Sensor& sensor, Threads threads = {1}) {
    std::vector<double> log_likelihoods(size());
    for_each_chunk(threads, [&](std::size_t, std::size_t begin, std::size_t count) {
      const std::span<const State> states = std::span<const State>(states_).subspan(begin, count);
      const std::span<double> out = std::span<double>(log_likelihoods).subspan(begin, count);
      if constexpr (std::invocable<const Sensor&, std::span<const State>, std::span<double>>) {
        sensor(states, out);
      } else {
        for (std::size_t i = 0; i < count; ++i) out[i] = sensor(states[i]);
      }
    });
    return reweight(log_likelihoods);
  }

  /// update with likelihoods computed elsewhere, one a particle. Returns the evidence log p(reading
  /// | readings before), up to the constant that the likelihoods leave out. -inf: no particle can
  /// explain the reading; the belief stays as it was. Throws UsageError, the belief untouched,
  /// where sizes differ or a value is NaN or +inf.
  double reweight(std::span<const double> log_likelihoods) {
    if (log_likelihoods.size() != size()) {
      throw UsageError("a particle filter needs one likelihood for each particle");
    }
    std::vector<double> products(size());
    for (std::size_t i = 0; i < size(); ++i) {
      // A particle that is ruled out stays so; a NaN must not hide behind it.
      products[i] = log_weights_[i] + log_likelihoods[i];
    }
    NormalisedLogWeights normalised = normalise_log_weights(std::move(products));
    if (!normalised.sum.any()) return normalised.sum.log_total;
    log_weights_ = std::move(normalised.log_weights);
    effective_sample_size_ = normalised.sum.effective_sample_size;
    return normalised.sum.log_total;
  }

  /// Draws `count` particles in proportion to the weights, and weighs them equally.
  /// Throws UsageError where count is 0 or the resampler's answer has another length or an index
  /// out of range.
  void resample(std::size_t count, const Resampler& resampler, Rng& rng) {
    take(resampler(weights(), count, rng), count);
  }
  void resample(std::size_t count, ResamplingScheme scheme, Rng& rng) {
    take(resample_indices(scheme, weights(), count, rng), count);
  }

  /// Becomes the mixture of this belief and another one that weighs exp(relative_log_weight) times
  /// as much as this. The other's particles follow this filter's. -inf leaves this belief as it is;
  /// NaN and +inf throw UsageError.
  void absorb(const ParticleFilter& other, double relative_log_weight) {
    if (relative_log_weight == -std::numeric_limits<double>::infinity()) return;
    if (!std::isfinite(relative_log_weight)) {
      throw UsageError("a belief to absorb needs a weight that is a number");
    }
    const std::size_t own = size();
    std::vector<double> joined(log_weights_);
    joined.reserve(own + other.size());
    for (std::size_t i = 0; i < other.size(); ++i) {
      joined.push_back(other.log_weights_[i] + relative_log_weight);
    }
    NormalisedLogWeights normalised = normalise_log_weights(std::move(joined));
    states_.insert(states_.end(), other.states_.begin(), other.states_.end());
    log_weights_ = std::move(normalised.log_weights);
    effective_sample_size_ = normalised.sum.effective_sample_size;
  }

 private:
  template <typename Body>
  void for_each_chunk(Threads threads, const Body& body) const {
    parallel_for((size() + kChunk - 1) / kChunk, threads, [&](std::size_t chunk) {
      const std::size_t begin = chunk * kChunk;
      body(chunk, begin, std::min(kChunk, size() - begin));
    });
  }

  void take(const std::vector<std::size_t>& indices, std::size_t count) {
    const auto out_of_range = [&](std::size_t index) { return index >= size(); };
    if (count == 0 || indices.size() != count ||
        std::any_of(indices.begin(), indices.end(), out_of_range)) {
      throw UsageError(
          "a resampler must return as many valid indices as it was asked for, at least one");
    }
    std::vector<State> taken;
    taken.reserve(count);
    for (const std::size_t index : indices) taken.push_back(states_[index]);
    states_ = std::move(taken);
    weigh_equally();
  }

  void weigh_equally() {
    const auto count = static_cast<double>(size());
    log_weights_.assign(size(), -std::log(count));
    effective_sample_size_ = count;
  }

  std::vector<State> states_;
  std::vector<double> log_weights_;
  double effective_sample_size_ = 0.0;
};

}  // namespace loopstone
