#include "loopstone/localization/particle_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "loopstone/localization/histogram_filter.hpp"

namespace loopstone {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double mean_of(const ParticleFilter<double>& filter) {
  const std::vector<double> weights = filter.weights();
  double mean = 0.0;
  for (std::size_t i = 0; i < filter.size(); ++i) mean += weights[i] * filter.states()[i];
  return mean;
}

double variance_of(const ParticleFilter<double>& filter) {
  const std::vector<double> weights = filter.weights();
  const double mean = mean_of(filter);
  double sum = 0.0;
  for (std::size_t i = 0; i < filter.size(); ++i) {
    const double offset = filter.states()[i] - mean;
    sum += weights[i] * offset * offset;
  }
  return sum;
}

double log_normal(double offset, double variance) {
  return -0.5 * (offset * offset / variance + std::log(2.0 * 3.14159265358979323846 * variance));
}

/// Standard normal particles.
ParticleFilter<double> normal_belief(std::size_t count, Rng& rng) {
  std::vector<double> states(count);
  for (double& state : states) state = rng.normal();
  return ParticleFilter<double>(std::move(states));
}

// Linear and Gaussian: the Kalman filter is the exact answer, evidence included.
TEST(ParticleFilter, AgreesWithTheKalmanFilter) {
  constexpr double kMotionVariance = 0.25;
  constexpr double kReadingVariance = 0.5;
  Rng rng(3);
  ParticleFilter<double> filter = normal_belief(20000, rng);
  double mean = 0.0;
  double variance = 1.0;
  for (const double reading : {0.7, 2.1, 2.4, 3.9, 4.4}) {
    filter.predict([](double x, Rng& noise) { return x + 1.0 + noise.normal(0.0, 0.5); }, rng);
    mean += 1.0;
    variance += kMotionVariance;
    const double exact_evidence = log_normal(reading - mean, variance + kReadingVariance);
    const double evidence =
        filter.update([&](double x) { return log_normal(reading - x, kReadingVariance); });
    EXPECT_NEAR(evidence, exact_evidence, 0.05);
    const double gain = variance / (variance + kReadingVariance);
    mean += gain * (reading - mean);
    variance *= 1.0 - gain;
    EXPECT_NEAR(mean_of(filter), mean, 0.04);
    EXPECT_NEAR(variance_of(filter), variance, 0.03);
    filter.resample(filter.size(), ResamplingScheme::kSystematic, rng);
    EXPECT_NEAR(mean_of(filter), mean, 0.04);
  }
}

// The same corridor for both filters of the library.
TEST(ParticleFilter, AgreesWithTheHistogramFilter) {
  const HistogramShape shape{.columns = 30, .column_edge = GridEdge::kRing};
  const auto kernel = normal_kernel(3.0, 1.0);
  const auto likelihood = [](int column) { return column % 7 == 0 ? 0.8 : 0.2; };
  HistogramFilter histogram(shape);
  std::vector<int> states(30000);
  for (std::size_t i = 0; i < states.size(); ++i) states[i] = static_cast<int>(i % 30);
  ParticleFilter<int> particles(std::move(states));
  Rng rng(5);
  for (int step = 0; step < 4; ++step) {
    histogram.predict(kernel);
    particles.predict(
        [&](int column, Rng& noise) {
          double at = noise.uniform();
          std::size_t k = 0;
          while (k + 1 < kernel.size() && at >= kernel[k].probability)
            at -= kernel[k++].probability;
          return shape.moved({column, 0}, kernel[k].shift).column;
        },
        rng);
    const double evidence = histogram.update([&](Cell cell) { return likelihood(cell.column); });
    const double log_evidence =
        particles.update([&](int column) { return std::log(likelihood(column)); });
    EXPECT_NEAR(std::exp(log_evidence), evidence, 0.01);
    particles.resample(particles.size(), ResamplingScheme::kResidual, rng);
  }
  std::vector<double> found(30, 0.0);
  for (const int column : particles.states())
    found[static_cast<std::size_t>(column)] += 1.0 / 30000.0;
  for (int column = 0; column < 30; ++column) {
    EXPECT_NEAR(found[static_cast<std::size_t>(column)], histogram.probability({column, 0}), 0.01);
  }
}

TEST(ParticleFilter, IsTheSameForAnyNumberOfThreads) {
  const auto run = [](Threads threads) {
    Rng rng(11);
    ParticleFilter<double> filter = normal_belief(1500, rng);
    for (int step = 0; step < 3; ++step) {
      filter.predict([](double x, Rng& noise) { return x + noise.normal(); }, rng, threads);
      filter.update([](double x) { return -x * x; }, threads);
      filter.resample(1500 - 100 * static_cast<std::size_t>(step), ResamplingScheme::kMultinomial,
                      rng);
    }
    return std::vector<double>(filter.states().begin(), filter.states().end());
  };
  EXPECT_EQ(run({1}), run({4}));
}

TEST(ParticleFilter, BatchesAndSinglesAreTheSame) {
  Rng single_rng(2);
  Rng batch_rng(2);
  ParticleFilter<double> singles = normal_belief(1000, single_rng);
  ParticleFilter<double> batches = normal_belief(1000, batch_rng);
  singles.predict([](double x, Rng& noise) { return x + noise.normal(); }, single_rng);
  batches.predict(
      [](std::span<double> states, Rng& noise) {
        for (double& state : states) state += noise.normal();
      },
      batch_rng);
  const double single_evidence = singles.update([](double x) { return -x * x; });
  const double batch_evidence =
      batches.update([](std::span<const double> states, std::span<double> log_likelihoods) {
        ASSERT_EQ(states.size(), log_likelihoods.size());
        for (std::size_t i = 0; i < states.size(); ++i) log_likelihoods[i] = -states[i] * states[i];
      });
  EXPECT_EQ(single_evidence, batch_evidence);
  EXPECT_TRUE(
      std::equal(singles.states().begin(), singles.states().end(), batches.states().begin()));
  EXPECT_TRUE(std::equal(singles.log_weights().begin(), singles.log_weights().end(),
                         batches.log_weights().begin()));
}

TEST(ParticleFilter, EveryPredictionHasItsOwnNoise) {
  Rng rng(2);
  ParticleFilter<double> filter(std::vector<double>(2000, 0.0));
  const auto walk = [](double x, Rng& noise) { return x + noise.normal(); };
  filter.predict(walk, rng);
  const std::vector<double> first(filter.states().begin(), filter.states().end());
  filter.predict(walk, rng);
  double correlation = 0.0;
  for (std::size_t i = 0; i < first.size(); ++i)
    correlation += first[i] * (filter.states()[i] - first[i]);
  EXPECT_LT(std::abs(correlation / 2000.0), 5.0 / std::sqrt(2000.0));
}

TEST(ParticleFilter, WeightsSumToOneAndSurviveAnyScale) {
  ParticleFilter<int> filter({1, 2, 3});
  const double evidence = filter.reweight(std::vector<double>{-5000.0, -5000.0, -kInfinity});
  EXPECT_NEAR(evidence, -5000.0 + std::log(2.0 / 3.0), 1e-9);
  EXPECT_NEAR(filter.weights()[0], 0.5, 1e-9);
  EXPECT_NEAR(filter.weights()[1], 0.5, 1e-9);
  EXPECT_EQ(filter.weights()[2], 0.0);
  EXPECT_NEAR(filter.effective_sample_size(), 2.0, 1e-9);
}

TEST(ParticleFilter, KeepsItsBeliefWhenNothingExplainsAReading) {
  ParticleFilter<int> filter({1, 2}, {std::log(3.0), 0.0});
  EXPECT_EQ(filter.update([](int) { return -kInfinity; }), -kInfinity);
  EXPECT_NEAR(filter.weights()[0], 0.75, 1e-12);
  EXPECT_THROW(filter.update([](int state) { return state == 2 ? kNan : 0.0; }), UsageError);
  EXPECT_THROW(filter.reweight(std::vector<double>{0.0}), UsageError);
  EXPECT_NEAR(filter.weights()[0], 0.75, 1e-12);
}

TEST(ParticleFilter, AbsorbsAnotherBeliefByItsWeight) {
  ParticleFilter<int> filter({1, 2}, {std::log(3.0), 0.0});
  filter.absorb(ParticleFilter<int>({7, 8}), std::log(3.0));
  EXPECT_EQ(std::vector<int>(filter.states().begin(), filter.states().end()),
            (std::vector<int>{1, 2, 7, 8}));
  const std::vector<double> expected{0.75 / 4, 0.25 / 4, 1.5 / 4, 1.5 / 4};
  const std::vector<double> weights = filter.weights();
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(weights[i], expected[i], 1e-12);
  EXPECT_NEAR(filter.effective_sample_size(), effective_sample_size(weights), 1e-9);
  filter.absorb(ParticleFilter<int>({9}), -kInfinity);
  EXPECT_EQ(filter.size(), 4U);
  EXPECT_THROW(filter.absorb(ParticleFilter<int>({9}), kNan), UsageError);
  EXPECT_THROW(filter.absorb(ParticleFilter<int>({9}), kInfinity), UsageError);
}

// Two beliefs with weights of their own are one belief: evidences of the parts, weighed, are the
// evidence of the whole.
TEST(ParticleFilter, AMixtureOfFiltersIsOneFilter) {
  ParticleFilter<double> left({-1.0, -2.0});
  ParticleFilter<double> right({1.0, 2.0, 3.0});
  ParticleFilter<double> whole = left;
  whole.absorb(right, std::log(0.6 / 0.4));
  const auto sensor = [](double x) { return -(x - 1.5) * (x - 1.5); };
  const double left_weight = 0.4 * std::exp(left.update(sensor));
  const double right_weight = 0.6 * std::exp(right.update(sensor));
  EXPECT_NEAR(whole.update(sensor), std::log(left_weight + right_weight), 1e-12);
  left.absorb(right, std::log(right_weight / left_weight));
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_NEAR(left.log_weights()[i], whole.log_weights()[i], 1e-12);
  }
}

TEST(ParticleFilter, RefusesNonsense) {
  EXPECT_THROW(ParticleFilter<int>(std::vector<int>{}), UsageError);
  EXPECT_THROW(ParticleFilter<int>({1, 2}, {0.0}), UsageError);
  EXPECT_THROW(ParticleFilter<int>({1}, {-kInfinity}), UsageError);
  EXPECT_THROW(ParticleFilter<int>({1}, {kNan}), UsageError);
  ParticleFilter<int> filter({1, 2});
  Rng rng(1);
  EXPECT_THROW(filter.resample(0, ResamplingScheme::kSystematic, rng), UsageError);
  const auto short_answer = [](std::span<const double>, std::size_t, Rng&) {
    return std::vector<std::size_t>{0};
  };
  EXPECT_THROW(filter.resample(2, short_answer, rng), UsageError);
  const auto wild_answer = [](std::span<const double>, std::size_t, Rng&) {
    return std::vector<std::size_t>{0, 2};
  };
  EXPECT_THROW(filter.resample(2, wild_answer, rng), UsageError);
  EXPECT_EQ(filter.size(), 2U);
}

}  // namespace
}  // namespace loopstone
