#include "loopstone/localization/beam_model.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "beam_samples.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

using test::random_mixture;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Simpson's rule over pieces that have no jump inside.
double integral(const BeamMixture& mixture, double max_range_m, double expected_m, double from,
                double to) {
  constexpr int kPieces = 4000;
  const double step = (to - from) / kPieces;
  double sum = 0.0;
  for (int i = 0; i < kPieces; ++i) {
    const double low = from + i * step;
    // A jump at the ends is not seen from inside.
    const double inside = 1e-9 * step;
    sum += beam_likelihood(mixture, max_range_m, low + inside, expected_m) +
           4.0 * beam_likelihood(mixture, max_range_m, low + 0.5 * step, expected_m) +
           beam_likelihood(mixture, max_range_m, low + step - inside, expected_m);
  }
  return sum * step / 6.0;
}

RC_GTEST_PROP(BeamModelLaws, EverythingThatCanBeMeasuredSumsToOne, (std::uint64_t seed)) {
  Rng rng(seed);
  const BeamMixture mixture = random_mixture(rng);
  const double max_range_m = rng.uniform(1.0, 40.0);
  const double expected[] = {0.0, max_range_m, kInfinity, 2.0 * max_range_m,
                             rng.uniform(0.0, max_range_m)};
  const double expected_m = expected[rng.below(5)];
  const double nothing = beam_likelihood(mixture, max_range_m, kInfinity, expected_m);
  RC_ASSERT(std::abs(beam_distribution(mixture, max_range_m, max_range_m, expected_m) + nothing -
                     1.0) < 1e-12);
  const double cut_m = std::min(expected_m, max_range_m);  // where the short part ends
  const double returns = integral(mixture, max_range_m, expected_m, 0.0, cut_m) +
                         integral(mixture, max_range_m, expected_m, cut_m, max_range_m);
  RC_ASSERT(std::abs(returns + nothing - 1.0) < 1e-6);
  const double below_m = rng.uniform(0.0, cut_m);
  RC_ASSERT(std::abs(integral(mixture, max_range_m, expected_m, 0.0, below_m) -
                     beam_distribution(mixture, max_range_m, below_m, expected_m)) < 1e-6);
}

TEST(BeamModel, PartsAreWhereTheyShouldBe) {
  const BeamMixture mixture{.hit_weight = 0.7,
                            .short_weight = 0.1,
                            .max_weight = 0.15,
                            .random_weight = 0.05,
                            .hit_sigma_m = 0.1,
                            .short_rate_per_m = 1.0};
  EXPECT_DOUBLE_EQ(beam_likelihood(mixture, 10.0, kInfinity, 4.0), 0.15);
  EXPECT_DOUBLE_EQ(beam_likelihood(mixture, 10.0, 10.0, 4.0), 0.15) << "the greatest range";
  EXPECT_DOUBLE_EQ(beam_likelihood(mixture, 10.0, kInfinity, kInfinity), 0.85);
  EXPECT_NEAR(beam_likelihood(mixture, 10.0, 8.0, 4.0), 0.005, 1e-12) << "random alone";
  EXPECT_NEAR(
      beam_likelihood(mixture, 10.0, 4.0, 4.0),
      0.7 / (0.1 * std::sqrt(2.0 * kPi)) + 0.1 * std::exp(-4.0) / (1 - std::exp(-4.0)) + 0.005,
      1e-12);
  EXPECT_GT(beam_likelihood(mixture, 10.0, 1.0, 4.0), beam_likelihood(mixture, 10.0, 2.0, 4.0));
  EXPECT_EQ(beam_likelihood(mixture, 10.0, kNaN, 4.0), 0.0);
  EXPECT_EQ(beam_likelihood(mixture, 10.0, -0.1, 4.0), 0.0);
}

/// A room of 6 m x 4 m with a pillar, in cells of 5 cm.
Grid<std::uint8_t> room() {
  Grid<std::uint8_t> grid(
      GridFrame{.origin = {-1.0, -1.0}, .resolution = 0.05, .columns = 120, .rows = 80});
  for (int row = 0; row < 80; ++row) {
    for (int column = 0; column < 120; ++column) {
      const bool wall = row == 0 || row == 79 || column == 0 || column == 119;
      const bool door = row == 0 && column > 80 && column < 100;
      const bool pillar = column > 70 && column < 80 && row > 50 && row < 62;
      if ((wall && !door) || pillar) grid[{column, row}] = 1;
    }
  }
  return grid;
}

struct Scan {
  std::vector<double> angles_rad{};
  std::vector<float> ranges_m{};
};

Scan scan_from(const WalkCaster& walk, const Pose2& map_T_lidar, const BeamMixture& mixture,
               Rng& rng) {
  Scan scan;
  for (int k = 0; k < 60; ++k) {
    const double angle = -2.3 + 4.6 * k / 59;
    const double expected_m = walk.range(ray_along(map_T_lidar * Pose2{0.0, 0.0, angle}));
    scan.angles_rad.push_back(angle);
    scan.ranges_m.push_back(
        static_cast<float>(test::sample_range(mixture, walk.max_range_m(), expected_m, rng)));
  }
  return scan;
}

TEST(BeamModel, LikelihoodsAreSumsOverBeams) {
  const Grid<std::uint8_t> map = room();
  const WalkCaster walk(map, 5.0);
  const BeamModel model{SphereCaster(map, 5.0)};
  Rng rng(1);
  const Pose2 robot_T_lidar{0.2, -0.1, 0.4};
  Scan scan = scan_from(walk, {1.0, 0.5, 0.3}, {}, rng);
  scan.ranges_m[7] = std::numeric_limits<float>::quiet_NaN();
  std::vector<Pose2> poses;
  for (int i = 0; i < 150; ++i) {
    poses.push_back({rng.uniform(-2.0, 6.0), rng.uniform(-2.0, 4.0), rng.uniform(-kPi, kPi)});
  }
  std::vector<double> out(poses.size());
  model.log_likelihoods(poses, {robot_T_lidar, scan.angles_rad, scan.ranges_m}, out, Threads{1});
  for (std::size_t i = 0; i < poses.size(); ++i) {
    double sum = 0.0;
    for (std::size_t k = 0; k < scan.angles_rad.size(); ++k) {
      if (k == 7) continue;
      const Pose2 lidar = poses[i] * robot_T_lidar;
      const double c = std::cos(lidar.yaw);
      const double s = std::sin(lidar.yaw);
      const double bc = std::cos(scan.angles_rad[k]);
      const double bs = std::sin(scan.angles_rad[k]);
      const double expected_m =
          walk.range({lidar.translation(), {c * bc - s * bs, s * bc + c * bs}});
      sum += model.log_likelihood(static_cast<double>(scan.ranges_m[k]), expected_m);
    }
    ASSERT_NEAR(out[i], sum, 1e-9);
  }
  std::vector<double> threaded(poses.size());
  model.log_likelihoods(poses, {robot_T_lidar, scan.angles_rad, scan.ranges_m}, threaded,
                        Threads{3});
  EXPECT_EQ(threaded, out);
}

TEST(BeamModel, TheTableIsTheMeanOfTheModelAndSumsToOne) {
  const BeamModelOptions options{.mixture = {.hit_sigma_m = 0.2}, .table_step_m = 0.1};
  const BeamModel model(WalkCaster(room(), 4.0), options);
  for (const double expected_m : {0.05, 0.31, 1.99, 3.95, 4.1, kInfinity}) {
    double sum = std::exp(model.log_likelihood(kInfinity, expected_m));
    for (int bin = 0; bin < 40; ++bin) {
      const double likelihood = std::exp(model.log_likelihood(0.1 * (bin + 0.5), expected_m));
      sum += likelihood * model.table_step_m();
    }
    EXPECT_NEAR(sum, 1.0, 1e-5) << expected_m;
  }
  // Of the same order as the model everywhere, and close to it where it is smooth.
  EXPECT_NEAR(std::exp(model.log_likelihood(2.05, 2.05)),
              beam_likelihood(options.mixture, 4.0, 2.05, 2.05), 0.1);
  EXPECT_NEAR(std::exp(model.log_likelihood(3.5, 2.05)),
              beam_likelihood(options.mixture, 4.0, 3.5, 2.05), 1e-4);
  EXPECT_EQ(model.log_likelihood(kNaN, 2.0), 0.0);
  EXPECT_EQ(model.memory_bytes(), 41U * 41U * 4U);
}

TEST(BeamModel, TheTruePlaceIsTheMostLikely) {
  const Grid<std::uint8_t> map = room();
  const WalkCaster walk(map, 8.0);
  const BeamMixture mixture{};
  const BeamModel models[] = {BeamModel(walk), BeamModel(SphereCaster(map, 8.0)),
                              BeamModel(TableCaster(map, 8.0, {}, {.headings = 180}))};
  Rng rng(2);
  for (int round = 0; round < 10; ++round) {
    const Pose2 truth{rng.uniform(0.0, 2.0), rng.uniform(-0.5, 2.0), rng.uniform(-kPi, kPi)};
    const Scan scan = scan_from(walk, truth, mixture, rng);
    std::vector<Pose2> poses{truth};
    for (int i = 0; i < 100; ++i) {
      const double way = rng.uniform(-kPi, kPi);
      const double off = rng.uniform(0.3, 1.0);
      poses.push_back({truth.x + off * std::cos(way), truth.y + off * std::sin(way),
                       wrap_angle(truth.yaw + rng.uniform(-0.5, 0.5))});
    }
    std::vector<double> out(poses.size());
    for (const BeamModel& model : models) {
      model.log_likelihoods(poses, {{}, scan.angles_rad, scan.ranges_m}, out);
      for (std::size_t i = 1; i < out.size(); ++i) ASSERT_GT(out[0], out[i]);
    }
  }
}

TEST(BeamModel, RejectsWhatCannotBe) {
  const WalkCaster walk(room(), 5.0);
  const auto model_with = [&](const BeamMixture& mixture, double step_m) {
    return BeamModel(walk, {.mixture = mixture, .table_step_m = step_m});
  };
  EXPECT_NO_THROW(model_with({}, 0.05));
  EXPECT_THROW(model_with({.hit_weight = 0.9}, 0.05), UsageError);
  EXPECT_THROW(model_with({.hit_weight = 0.95, .max_weight = -0.15}, 0.05), UsageError);
  EXPECT_THROW(model_with({.hit_sigma_m = 0.0}, 0.05), UsageError);
  EXPECT_THROW(model_with({.short_rate_per_m = kNaN}, 0.05), UsageError);
  EXPECT_THROW(model_with({}, 0.0), UsageError);
  EXPECT_THROW(model_with({}, 1e-4), UsageError);
  const BeamModel model(walk);
  const std::vector<Pose2> poses(2);
  const std::vector<double> angles_rad(3);
  const std::vector<float> ranges_m(3);
  std::vector<double> out(2);
  EXPECT_NO_THROW(model.log_likelihoods(poses, {{}, angles_rad, ranges_m}, out));
  EXPECT_THROW(model.log_likelihoods(poses, {{}, angles_rad, {}}, out), UsageError);
  out.resize(1);
  EXPECT_THROW(model.log_likelihoods(poses, {{}, angles_rad, ranges_m}, out), UsageError);
}

}  // namespace
}  // namespace loopstone
