#include "loopstone/localization/beam_model_learning.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "beam_samples.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/simulation/surface_index.hpp"
#include "loopstone/simulation/world.hpp"

namespace loopstone {
namespace {

using test::random_mixture;
using test::sample_range;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMaxRangeM = 12.0;

/// Expected ranges of all kinds: in a wall, near, far, nothing.
double random_expected(Rng& rng) {
  const double kinds[] = {0.0, kInfinity, rng.uniform(0.0, 0.5), rng.uniform(11.5, kMaxRangeM)};
  return rng.uniform() < 0.15 ? kinds[rng.below(4)] : rng.uniform(0.3, 11.7);
}

std::vector<RangePair> sample_pairs(const BeamMixture& mixture, std::size_t count, Rng& rng) {
  std::vector<RangePair> pairs;
  for (std::size_t i = 0; i < count; ++i) {
    const double expected_m = random_expected(rng);
    pairs.push_back({sample_range(mixture, kMaxRangeM, expected_m, rng), expected_m});
  }
  return pairs;
}

double naive_mean_log_likelihood(const BeamMixture& mixture, const std::vector<RangePair>& pairs) {
  double sum = 0.0;
  for (const RangePair& pair : pairs) {
    sum += std::log(beam_likelihood(mixture, kMaxRangeM, pair.measured_m, pair.expected_m));
  }
  return sum / static_cast<double>(pairs.size());
}

RC_GTEST_PROP(BeamLearningLaws, EveryStepRaisesTheLikelihood, (std::uint64_t seed)) {
  Rng rng(seed);
  const auto pairs = sample_pairs(random_mixture(rng), 100, rng);
  const BeamMixture initial = random_mixture(rng);
  const BeamLearningResult result =
      learn_beam_mixture(pairs, kMaxRangeM, initial, {.max_iterations = 15});
  RC_ASSERT(result.status != BeamLearningStatus::kTooFewPairs);
  RC_ASSERT(result.pairs_used == 100);
  const auto& course = result.mean_log_likelihood;
  RC_ASSERT(course.size() == static_cast<std::size_t>(result.iterations) + 1);
  for (std::size_t i = 1; i < course.size(); ++i) RC_ASSERT(course[i] >= course[i - 1] - 1e-12);
  RC_ASSERT(std::abs(course.front() - naive_mean_log_likelihood(initial, pairs)) < 1e-9);
  RC_ASSERT(std::abs(course.back() - naive_mean_log_likelihood(result.mixture, pairs)) < 1e-9);
  const BeamMixture& learned = result.mixture;
  RC_ASSERT(std::abs(learned.hit_weight + learned.short_weight + learned.max_weight +
                     learned.random_weight - 1.0) < 1e-9);
}

TEST(BeamLearning, FindsTheMixtureThatMadeTheData) {
  for (const std::uint64_t seed : {1U, 2U}) {
    Rng rng(seed);
    const BeamMixture truth{.hit_weight = rng.uniform(0.5, 0.6),
                            .short_weight = rng.uniform(0.15, 0.25),
                            .max_weight = 0.1,
                            .random_weight = 0.0,
                            .hit_sigma_m = rng.uniform(0.03, 0.15),
                            .short_rate_per_m = rng.uniform(0.4, 1.5)};
    BeamMixture whole = truth;
    whole.random_weight = 0.9 - truth.hit_weight - truth.short_weight;
    const auto pairs = sample_pairs(whole, 20000, rng);
    const auto result = learn_beam_mixture(pairs, kMaxRangeM);
    EXPECT_EQ(result.status, BeamLearningStatus::kConverged);
    EXPECT_NEAR(result.mixture.hit_weight, whole.hit_weight, 0.015);
    EXPECT_NEAR(result.mixture.short_weight, whole.short_weight, 0.03);
    EXPECT_NEAR(result.mixture.max_weight, whole.max_weight, 0.015);
    EXPECT_NEAR(result.mixture.random_weight, whole.random_weight, 0.03);
    EXPECT_NEAR(result.mixture.hit_sigma_m / whole.hit_sigma_m, 1.0, 0.05);
    EXPECT_NEAR(result.mixture.short_rate_per_m / whole.short_rate_per_m, 1.0, 0.2);
    EXPECT_GE(result.mean_log_likelihood.back(), naive_mean_log_likelihood(whole, pairs));
  }
}

/// Where ranges are cut off, the closed form takes the rest for the whole and finds too small a
/// sigma.
TEST(BeamLearning, SigmaIsRightBesideTheEnds) {
  Rng rng(5);
  const BeamMixture truth{.hit_weight = 0.9,
                          .short_weight = 0.02,
                          .max_weight = 0.05,
                          .random_weight = 0.03,
                          .hit_sigma_m = 0.3,
                          .short_rate_per_m = 1.0};
  std::vector<RangePair> pairs;
  double squares = 0.0;
  for (int i = 0; i < 6000; ++i) {
    const double expected_m = i % 2 == 0 ? 0.3 : kMaxRangeM - 0.3;
    pairs.push_back({sample_range(truth, kMaxRangeM, expected_m, rng), expected_m});
    const double error = pairs.back().measured_m - expected_m;
    if (std::abs(error) < 1.5) squares += error * error;
  }
  EXPECT_LT(std::sqrt(squares / 5400.0), 0.3 * 0.97) << "or this test shows nothing";
  const auto result = learn_beam_mixture(pairs, kMaxRangeM);
  EXPECT_NEAR(result.mixture.hit_sigma_m, 0.3, 0.02);
}

TEST(BeamLearning, PartsWithoutWeightStayAway) {
  Rng rng(6);
  const auto pairs = sample_pairs({}, 2000, rng);
  const BeamMixture no_short{
      .hit_weight = 0.8, .short_weight = 0.0, .max_weight = 0.1, .random_weight = 0.1};
  EXPECT_EQ(learn_beam_mixture(pairs, kMaxRangeM, no_short).mixture.short_weight, 0.0);
  // Nothing explains a beam without return then: no numbers that are none.
  const BeamMixture no_max{
      .hit_weight = 0.8, .short_weight = 0.1, .max_weight = 0.0, .random_weight = 0.1};
  const auto result = learn_beam_mixture(pairs, kMaxRangeM, no_max);
  EXPECT_EQ(result.mixture.max_weight, 0.0);
  EXPECT_TRUE(std::isfinite(result.mixture.hit_weight + result.mixture.hit_sigma_m));
}

TEST(BeamLearning, LeavesOutWhatSaysNothing) {
  std::vector<RangePair> pairs(9, {2.0, 2.0});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 100; ++i) pairs.push_back({nan, 2.0});
  for (int i = 0; i < 100; ++i) pairs.push_back({2.0, nan});
  for (int i = 0; i < 100; ++i) pairs.push_back({-1.0, 2.0});
  const auto few = learn_beam_mixture(pairs, kMaxRangeM);
  EXPECT_EQ(few.status, BeamLearningStatus::kTooFewPairs);
  EXPECT_EQ(few.pairs_used, 9);
  EXPECT_EQ(few.mixture.hit_weight, BeamMixture{}.hit_weight);
  pairs.push_back({2.0, 2.0});
  const auto exact = learn_beam_mixture(pairs, kMaxRangeM, {}, {.sigma_min_m = 0.004});
  EXPECT_EQ(exact.pairs_used, 10);
  EXPECT_GE(exact.mixture.hit_sigma_m, 0.004) << "data without noise do not end in a spike";
  EXPECT_THROW((void)learn_beam_mixture(pairs, 0.0), UsageError);
  EXPECT_THROW((void)learn_beam_mixture(pairs, 5.0, {.hit_weight = 0.1}), UsageError);
}

/// Scans of an office in which people stand about, on the office's map: what is learned is what was
/// put in, but for the map's cells, which widen sigma.
TEST(BeamLearning, LearnsFromScansOfAWorld) {
  const World world = make_world("office", 3);
  const SurfaceIndex surfaces(world.plan);
  const Grid<std::int8_t> map = true_map(world, 0.05);
  Grid<std::uint8_t> occupied(map.frame());
  for (std::size_t i = 0; i < occupied.cells().size(); ++i) {
    occupied.cells()[i] = map.cells()[i] >= 65 ? 1 : 0;
  }
  const RayCaster caster = SphereCaster(occupied, 15.0);
  Rng rng(7);
  std::vector<double> angles_rad;
  for (int k = 0; k < 60; ++k) angles_rad.push_back(-2.3 + 4.6 * k / 59);
  std::vector<RangePair> pairs;
  for (int scan = 0; scan < 200;) {
    const Cell cell{static_cast<int>(rng.below(static_cast<std::uint64_t>(map.frame().columns))),
                    static_cast<int>(rng.below(static_cast<std::uint64_t>(map.frame().rows)))};
    const Eigen::Vector2d at = map.frame().centre_of(cell);
    if (map[cell] != 0 || surfaces.distance(at, 1.0) < 0.5) continue;
    ++scan;
    const Pose2 pose{at.x(), at.y(), rng.uniform(-kPi, kPi)};
    std::vector<float> ranges_m;
    for (const double angle : angles_rad) {
      const double true_m = surfaces.cast(at, ray_along(pose * Pose2{0, 0, angle}).direction, 15.0);
      double measured_m = true_m + rng.normal(0.0, 0.02);
      const double person_m = -std::log(1.0 - rng.uniform()) / 0.1;  // one in 10 m
      if (person_m < true_m) measured_m = person_m;
      if (rng.uniform() < 0.05) measured_m = kInfinity;
      ranges_m.push_back(static_cast<float>(std::max(measured_m, 0.0)));
    }
    const auto of_scan = range_pairs(caster, pose, {{}, angles_rad, ranges_m});
    pairs.insert(pairs.end(), of_scan.begin(), of_scan.end());
  }
  const auto result = learn_beam_mixture(pairs, 15.0);
  EXPECT_EQ(result.status, BeamLearningStatus::kConverged);
  EXPECT_GT(result.mixture.hit_weight, 0.5);
  EXPECT_GT(result.mixture.short_weight, 0.1);
  EXPECT_NEAR(result.mixture.max_weight, 0.05, 0.015);
  EXPECT_LT(result.mixture.random_weight, 0.1);
  EXPECT_GT(result.mixture.hit_sigma_m, 0.015);
  EXPECT_LT(result.mixture.hit_sigma_m, 0.06);
  EXPECT_GT(result.mean_log_likelihood.back(), result.mean_log_likelihood.front() + 0.02);
}

}  // namespace
}  // namespace loopstone
