#include "loopstone/localization/resampling.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "loopstone/base/error.hpp"
#include "support/generators.hpp"

namespace loopstone {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

constexpr ResamplingScheme kSchemes[] = {
    ResamplingScheme::kMultinomial, ResamplingScheme::kStratified, ResamplingScheme::kSystematic,
    ResamplingScheme::kResidual};

std::vector<int> copies_of(const std::vector<std::size_t>& indices, std::size_t particles) {
  std::vector<int> copies(particles, 0);
  for (const std::size_t index : indices) ++copies.at(index);
  return copies;
}

/// Mean and variance of the copies of every particle over many draws.
struct CopyMoments {
  std::vector<double> mean;
  std::vector<double> variance;

  [[nodiscard]] double total_variance() const {
    double sum = 0.0;
    for (const double value : variance) sum += value;
    return sum;
  }
};

CopyMoments copy_moments(ResamplingScheme scheme, const std::vector<double>& weights,
                         std::size_t count, int draws) {
  CopyMoments moments{std::vector<double>(weights.size(), 0.0),
                      std::vector<double>(weights.size(), 0.0)};
  Rng rng(7);
  for (int draw = 0; draw < draws; ++draw) {
    const auto copies = copies_of(resample_indices(scheme, weights, count, rng), weights.size());
    for (std::size_t i = 0; i < weights.size(); ++i) {
      moments.mean[i] += copies[i];
      moments.variance[i] += static_cast<double>(copies[i]) * copies[i];
    }
  }
  for (std::size_t i = 0; i < weights.size(); ++i) {
    moments.mean[i] /= draws;
    moments.variance[i] = moments.variance[i] / draws - moments.mean[i] * moments.mean[i];
  }
  return moments;
}

rc::Gen<std::vector<double>> any_weights() {
  const auto weight = rc::gen::oneOf(rc::gen::element(0.0, 1.0, 1e-12), test::between(0.0, 1.0));
  return rc::gen::suchThat(rc::gen::container<std::vector<double>>(weight),
                           [](const std::vector<double>& weights) {
                             return std::any_of(weights.begin(), weights.end(),
                                                [](double value) { return value > 0.0; });
                           });
}

TEST(Resampling, IsUnbiasedInEveryScheme) {
  const std::vector<double> weights{0.05, 0.0, 0.31, 0.14, 0.5};  // sums to 1
  constexpr std::size_t kCount = 7;
  constexpr int kDraws = 20000;
  for (const ResamplingScheme scheme : kSchemes) {
    const CopyMoments moments = copy_moments(scheme, weights, kCount, kDraws);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      // Five standard deviations of the mean of a multinomial draw, which scatters most.
      const double expected = kCount * weights[i];
      const double bound = 5.0 * std::sqrt(expected * (1.0 - weights[i]) / kDraws);
      EXPECT_NEAR(moments.mean[i], expected, bound) << to_string(scheme) << " particle " << i;
    }
  }
}

// Douc, Cappe and Moulines 2005: stratified and residual never scatter more than multinomial.
// Systematic scatters least here.
TEST(Resampling, SchemesScatterInTheirOrder) {
  const std::vector<double> weights{0.05, 0.1, 0.31, 0.14, 0.4};
  const auto scatter = [&](ResamplingScheme scheme) {
    return copy_moments(scheme, weights, 7, 20000).total_variance();
  };
  const double multinomial = scatter(ResamplingScheme::kMultinomial);
  const double stratified = scatter(ResamplingScheme::kStratified);
  const double residual = scatter(ResamplingScheme::kResidual);
  const double systematic = scatter(ResamplingScheme::kSystematic);
  double expected = 0.0;
  for (const double weight : weights) expected += 7 * weight * (1.0 - weight);
  EXPECT_NEAR(multinomial, expected, 0.05 * expected);
  EXPECT_LT(stratified, 0.7 * multinomial);
  EXPECT_LT(residual, 0.7 * multinomial);
  EXPECT_LT(systematic, 0.9 * stratified);
  EXPECT_LT(systematic, 0.9 * residual);
}

RC_GTEST_PROP(Resampling, CopiesStayNearTheirExpectation, ()) {
  const std::vector<double> weights = *any_weights();
  const auto count = *rc::gen::inRange<std::size_t>(0, 200);
  Rng rng(*rc::gen::arbitrary<std::uint64_t>());
  double total = 0.0;
  for (const double weight : weights) total += weight;
  for (const ResamplingScheme scheme : kSchemes) {
    const auto indices = resample_indices(scheme, weights, count, rng);
    RC_ASSERT(indices.size() == count);
    RC_ASSERT(std::is_sorted(indices.begin(), indices.end()));
    const auto copies = copies_of(indices, weights.size());
    for (std::size_t i = 0; i < weights.size(); ++i) {
      constexpr double kRounding = 1e-9;
      const double expected = static_cast<double>(count) * weights[i] / total;
      if (weights[i] == 0.0) RC_ASSERT(copies[i] == 0);
      if (scheme == ResamplingScheme::kSystematic) {
        RC_ASSERT(copies[i] >= std::floor(expected - kRounding));
        RC_ASSERT(copies[i] <= std::ceil(expected + kRounding));
      }
      if (scheme == ResamplingScheme::kStratified) {
        RC_ASSERT(std::abs(copies[i] - expected) <= 2.0 + kRounding);
      }
      if (scheme == ResamplingScheme::kResidual) {
        RC_ASSERT(copies[i] >= std::floor(expected - kRounding));
      }
    }
  }
}

TEST(Resampling, TheOnlyWeightTakesAll) {
  for (const ResamplingScheme scheme : kSchemes) {
    Rng rng(1);
    EXPECT_EQ(
        copies_of(resample_indices(scheme, std::vector<double>{0.0, 0.0, 1e-300, 0.0}, 9, rng), 4),
        (std::vector<int>{0, 0, 9, 0}))
        << to_string(scheme);
    EXPECT_EQ(resample_indices(scheme, std::vector<double>{3.0}, 2, rng),
              (std::vector<std::size_t>{0, 0}));
  }
}

TEST(Resampling, RefusesWeightsThatAreNone) {
  for (const ResamplingScheme scheme : kSchemes) {
    Rng rng(1);
    for (const std::vector<double>& bad :
         {std::vector<double>{}, {0.0, 0.0}, {1.0, kNan}, {1.0, -0.1}, {kInfinity, 1.0}}) {
      EXPECT_THROW((void)resample_indices(scheme, bad, 3, rng), UsageError) << to_string(scheme);
    }
  }
}

TEST(LogWeights, AreNormalisedOnAnyScale) {
  for (const double offset : {0.0, -1e5, 1e5}) {
    const auto normalised =
        normalise_log_weights({offset + std::log(1.0), offset + std::log(3.0), -kInfinity});
    EXPECT_NEAR(normalised.sum.log_total, offset + std::log(4.0), 1e-9);
    EXPECT_NEAR(normalised.sum.effective_sample_size, 16.0 / 10.0, 1e-9);
    EXPECT_NEAR(std::exp(normalised.log_weights[1]), 0.75, 1e-9);
    EXPECT_EQ(normalised.log_weights[2], -kInfinity);
  }
}

TEST(LogWeights, SayWhenNothingIsLeft) {
  const auto none = normalise_log_weights({-kInfinity, -kInfinity});
  EXPECT_FALSE(none.sum.any());
  EXPECT_EQ(none.sum.log_total, -kInfinity);
  EXPECT_EQ(none.log_weights, (std::vector<double>{-kInfinity, -kInfinity}));
  EXPECT_FALSE(sum_log_weights({}).any());
  EXPECT_EQ(weights_from_log(none.log_weights), (std::vector<double>{0.0, 0.0}));
  EXPECT_THROW((void)normalise_log_weights({0.0, kNan}), UsageError);
  EXPECT_THROW((void)normalise_log_weights({kInfinity}), UsageError);
}

RC_GTEST_PROP(LogWeights, AgreeWithPlainWeights, ()) {
  const std::vector<double> weights = *any_weights();
  std::vector<double> logs(weights.size());
  std::transform(weights.begin(), weights.end(), logs.begin(),
                 [](double w) { return std::log(w); });
  const double expected = effective_sample_size(weights);
  RC_ASSERT(std::abs(sum_log_weights(logs).effective_sample_size - expected) < 1e-9 * expected);
  double total = 0.0;
  for (const double weight : weights) total += weight;
  const std::vector<double> back = weights_from_log(logs);
  for (std::size_t i = 0; i < back.size(); ++i) {
    RC_ASSERT(std::abs(back[i] - weights[i] / total) < 1e-12);
  }
}

TEST(EffectiveSampleSize, CountsEqualWeights) {
  EXPECT_DOUBLE_EQ(effective_sample_size(std::vector<double>{2.0, 2.0, 2.0, 0.0}), 3.0);
  EXPECT_DOUBLE_EQ(effective_sample_size(std::vector<double>{0.0, 5.0}), 1.0);
  EXPECT_DOUBLE_EQ(effective_sample_size(std::vector<double>{0.0}), 0.0);
}

// n = chi2 quantile / (2 epsilon); quantiles from a table of the chi-square distribution.
TEST(KldSampleCount, FollowsTheChiSquareQuantile) {
  constexpr double kZ99 = 2.3263;
  EXPECT_NEAR(static_cast<double>(kld_sample_count(11, 0.05, kZ99)), 23.209 / 0.1, 3.0);
  EXPECT_NEAR(static_cast<double>(kld_sample_count(101, 0.05, kZ99)), 135.807 / 0.1, 3.0);
  EXPECT_NEAR(static_cast<double>(kld_sample_count(101, 0.01, 1.6449)), 124.342 / 0.02, 10.0);
  EXPECT_EQ(kld_sample_count(0, 0.05, kZ99), 1U);
  EXPECT_EQ(kld_sample_count(1, 0.05, kZ99), 1U);
  EXPECT_THROW((void)kld_sample_count(5, 0.0, kZ99), UsageError);
}

}  // namespace
}  // namespace loopstone
