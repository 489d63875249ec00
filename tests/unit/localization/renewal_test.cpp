#include "loopstone/localization/renewal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "loopstone/localization/injection.hpp"

namespace loopstone {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

KldSize<double> unit_bins() {
  return {.bin_of = [](double x) { return static_cast<std::uint64_t>(x); },
          .min_count = 50,
          .max_count = 5000};
}

std::vector<double> spread_over(double bins, std::size_t count) {
  std::vector<double> states(count);
  for (std::size_t i = 0; i < count; ++i) {
    states[i] = bins * (static_cast<double>(i) + 0.5) / static_cast<double>(count);
  }
  return states;
}

TEST(AdaptiveCount, GrowsWithTheSpread) {
  Rng rng(1);
  const auto count = [&](double bins) {
    return adaptive_count(ParticleFilter<double>(spread_over(bins, 3000)), unit_bins(), rng);
  };
  EXPECT_EQ(count(1.0), 50U);
  // All bins are found, so the answer is the bound for that many.
  EXPECT_EQ(count(20.0), kld_sample_count(20, 0.05, 2.326));
  EXPECT_EQ(count(60.0), kld_sample_count(60, 0.05, 2.326));
  EXPECT_EQ(count(3000.0), 5000U);
}

TEST(AdaptiveCount, LooksOnlyWhereTheBeliefIs) {
  std::vector<double> log_weights(3000, -kInfinity);
  for (std::size_t i = 0; i < 100; ++i) log_weights[i] = 0.0;  // the first bin of thirty
  Rng rng(1);
  const ParticleFilter<double> filter(spread_over(30.0, 3000), log_weights);
  EXPECT_EQ(adaptive_count(filter, unit_bins(), rng), 50U);
}

TEST(Renewal, WaitsForTheEffectiveSampleSize) {
  Rng rng(1);
  ParticleFilter<double> filter(spread_over(1.0, 100));
  const FilterStep even = renew(filter, Renewal<double>{}, 0.0, rng);
  EXPECT_FALSE(even.resampled);
  EXPECT_NEAR(even.effective_sample_size, 100.0, 1e-9);
  (void)filter.update([](double x) { return x < 0.1 ? 0.0 : -kInfinity; });
  const FilterStep uneven = renew(filter, Renewal<double>{}, 0.0, rng);
  EXPECT_TRUE(uneven.resampled);
  EXPECT_NEAR(uneven.effective_sample_size, 10.0, 1e-9);
  EXPECT_EQ(filter.size(), 100U);
  for (const double state : filter.states()) EXPECT_LT(state, 0.1);
}

TEST(Renewal, InjectsItsShareAndKeepsTheNumber) {
  Rng rng(4);
  ParticleFilter<double> filter(std::vector<double>(10000, 0.0));
  Renewal<double> renewal;
  renewal.injection = {.share = [](double log_evidence) { return log_evidence; },
                       .sample = [](Rng&) { return 1.0; }};
  const FilterStep step = renew(filter, renewal, 0.25, rng);
  EXPECT_TRUE(step.resampled);
  EXPECT_EQ(filter.size(), 10000U);
  EXPECT_NEAR(static_cast<double>(step.injected), 2500.0, 5.0 * std::sqrt(10000 * 0.25 * 0.75));
  std::size_t fresh = 0;
  for (const double state : filter.states()) fresh += state == 1.0 ? 1U : 0U;
  EXPECT_EQ(fresh, step.injected);
  EXPECT_NEAR(filter.effective_sample_size(), 10000.0, 1e-6);

  // Even a share of one keeps something of the old belief: a single reading is not the whole truth.
  EXPECT_EQ(renew(filter, renewal, 1.0, rng).injected, 9999U);
  EXPECT_FALSE(renew(filter, renewal, 0.0, rng).resampled);
}

// A robot that is carried off: without fresh samples the belief can't follow, with them it does.
TEST(Renewal, InjectionFindsAKidnappedRobot) {
  const auto walk = [](double x, Rng& noise) { return x + noise.normal(0.0, 0.02); };
  const auto run = [&](bool inject) {
    Rng rng(8);
    AugmentedInjection augmented(0.02, 0.3);
    Renewal<double> renewal;
    if (inject) {
      renewal.injection = {
          .share = [&](double evidence) { return augmented.share_after(evidence); },
          .sample = [](Rng& draw) { return draw.uniform(0.0, 10.0); }};
    }
    ParticleFilter<double> filter(spread_over(10.0, 500));
    for (int step = 0; step < 60; ++step) {
      const double truth = step < 30 ? 2.0 : 8.0;
      // A little of the likelihood is spread evenly, as in any real sensor model.
      const auto sensor = [&](double x) {
        return std::log(std::exp(-0.5 * (x - truth) * (x - truth) / 0.01) + 1e-4);
      };
      (void)filter_step(filter, walk, sensor, renewal, rng);
    }
    const std::vector<double> weights = filter.weights();
    double near = 0.0;
    for (std::size_t i = 0; i < filter.size(); ++i) {
      if (std::abs(filter.states()[i] - 8.0) < 0.5) near += weights[i];
    }
    return near;
  };
  EXPECT_LT(run(false), 0.01);
  EXPECT_GT(run(true), 0.9);
}

// The formula of Thrun, table 8.3, on plain numbers.
TEST(AugmentedInjection, IsThrunsTableInLogarithms) {
  AugmentedInjection augmented(0.05, 0.5);
  EXPECT_EQ(augmented.share_after(std::log(0.4)), 0.0);
  double slow = 0.4;
  double fast = 0.4;
  for (const double evidence : {0.5, 0.1, 0.01, 0.3, 0.9}) {
    slow += 0.05 * (evidence - slow);
    fast += 0.5 * (evidence - fast);
    EXPECT_NEAR(augmented.share_after(std::log(evidence)), std::max(0.0, 1.0 - fast / slow), 1e-12);
  }
}

TEST(AugmentedInjection, DoesNotDependOnTheScale) {
  AugmentedInjection plain(0.05, 0.5);
  AugmentedInjection tiny(0.05, 0.5);
  for (const double evidence : {-3.0, -4.0, -20.0, -2.0}) {
    EXPECT_NEAR(plain.share_after(evidence), tiny.share_after(evidence - 5000.0), 1e-9);
  }
}

TEST(AugmentedInjection, CopesWithReadingsThatNothingExplains) {
  AugmentedInjection augmented(0.05, 0.5);
  EXPECT_EQ(augmented.share_after(-kInfinity), 0.0) << "nothing to compare with yet";
  EXPECT_EQ(augmented.share_after(-1.0), 0.0);
  EXPECT_NEAR(augmented.share_after(-kInfinity), 1.0 - 0.5 / 0.95, 1e-12);
  augmented.reset();
  EXPECT_EQ(augmented.share_after(-100.0), 0.0);
  EXPECT_THROW((void)augmented.share_after(std::nan("")), UsageError);
  EXPECT_THROW(AugmentedInjection(0.5, 0.1), UsageError);
  EXPECT_THROW(AugmentedInjection(0.0, 0.1), UsageError);
}

}  // namespace
}  // namespace loopstone
