#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <unordered_set>
#include <vector>

#include "loopstone/localization/particle_filter.hpp"

namespace loopstone {

/// How many particles a belief needs: so many that their histogram over bins is close to that of
/// the belief. A belief spread over many bins gets many particles, one in a single bin gets
/// min_count.
template <typename State>
struct KldSize {
  std::function<std::uint64_t(const State&)>
      bin_of;  ///< equal for states that need not be told apart
  std::size_t min_count = 100;
  std::size_t max_count = 10000;
  double epsilon = 0.05;      ///< largest Kullback-Leibler distance
  double z_quantile = 2.326;  ///< it holds with the probability of this normal quantile, here 99 %
};

/// Draws from the belief until the draws are enough for the bins they fell into.
/// Source: Fox 2003, "Adapting the sample size in particle filters through KLD-sampling", table 2.
template <typename State>
[[nodiscard]] std::size_t adaptive_count(const ParticleFilter<State>& filter,
                                         const KldSize<State>& size, Rng& rng) {
  std::vector<double> sums = filter.weights();
  for (std::size_t i = 1; i < sums.size(); ++i) sums[i] += sums[i - 1];
  std::unordered_set<std::uint64_t> bins;
  std::size_t needed = std::max<std::size_t>(1, size.min_count);
  for (std::size_t drawn = 0; drawn < needed && drawn < size.max_count; ++drawn) {
    const double at = rng.uniform() * sums.back();
    const auto found = std::upper_bound(sums.begin(), sums.end() - 1, at);
    const State& state = filter.states()[static_cast<std::size_t>(found - sums.begin())];
    if (!bins.insert(size.bin_of(state)).second) continue;
    needed = std::max(needed, kld_sample_count(bins.size(), size.epsilon, size.z_quantile));
  }
  return std::min(needed, std::max<std::size_t>(1, size.max_count));
}

/// Fresh samples for a belief that may have lost the truth.
template <typename State>
struct Injection {
  std::function<double(double log_evidence)>
      share;                          ///< [0, 1], told of every reading: AugmentedInjection
  std::function<State(Rng&)> sample;  ///< from where the truth may be
};

/// When and how the particles are drawn anew after a reading. The default: systematic, as many as
/// there are, when the effective sample size has fallen to half.
template <typename State>
struct Renewal {
  Resampler resampler = resampler_of(ResamplingScheme::kSystematic);
  double effective_share = 0.5;          ///< resample below this effective sample size per particle
  std::optional<KldSize<State>> size{};  ///< nothing: the number stays
  std::optional<Injection<State>> injection{};  ///< nothing: no fresh samples
};

/// What a step of a filter did.
struct FilterStep {
  double log_evidence = 0.0;           ///< of the reading; -inf: no particle could explain it
  double effective_sample_size = 0.0;  ///< after the reading, before particles were drawn anew
  bool resampled = false;
  std::size_t injected = 0;  ///< fresh samples among the particles
};

/// Draws the particles anew where the policy says so; fresh samples always cause it, so that the
/// number is kept.
template <typename State>
FilterStep renew(ParticleFilter<State>& filter, const Renewal<State>& renewal, double log_evidence,
                 Rng& rng) {
  FilterStep step{.log_evidence = log_evidence,
                  .effective_sample_size = filter.effective_sample_size()};
  const auto particles = static_cast<double>(filter.size());
  const double share = renewal.injection ? renewal.injection->share(log_evidence) : 0.0;
  step.resampled = share > 0.0 || step.effective_sample_size < renewal.effective_share * particles;
  if (!step.resampled) return step;

  const std::size_t count =
      renewal.size ? adaptive_count(filter, *renewal.size, rng) : filter.size();
  for (std::size_t i = 1; i < count && share > 0.0; ++i) {
    step.injected += rng.uniform() < share ? 1U : 0U;
  }
  filter.resample(count - step.injected, renewal.resampler, rng);
  if (step.injected == 0) return step;

  std::vector<State> fresh;
  fresh.reserve(step.injected);
  for (std::size_t i = 0; i < step.injected; ++i) fresh.push_back(renewal.injection->sample(rng));
  const auto ratio = static_cast<double>(step.injected) / static_cast<double>(filter.size());
  filter.absorb(ParticleFilter<State>(std::move(fresh)), std::log(ratio));
  return step;
}

/// One round of the filter: move, weigh, draw anew. Callables as ParticleFilter's predict and
/// update take them.
template <typename State, typename Motion, typename Sensor>
FilterStep filter_step(ParticleFilter<State>& filter, const Motion& motion, const Sensor& sensor,
                       const Renewal<State>& renewal, Rng& rng, Threads threads = {1}) {
  filter.predict(motion, rng, threads);
  const double log_evidence = filter.update(sensor, threads);
  return renew(filter, renewal, log_evidence, rng);
}

}  // namespace loopstone
