#include "loopstone/localization/likelihood_field_model.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>

#include "localization/field_lookup.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "support/generators.hpp"

namespace loopstone {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Runs a body once for each instruction set that this processor has and the library was compiled
/// for.
template <typename Body>
void on_each_instruction_set(const Body& body) {
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    body(hwy::TargetName(target));
  }
  hwy::SetSupportedTargetsForTest(0);
}

// The naive twin: one pose and one point at a time, from the public costs of cells, with the same
// roundings.

struct SinCos {
  double sin;
  double cos;
};

SinCos twin_sin_cos(double angle) {
  const double quarters = std::nearbyint(angle * 0.63661977236758134308);
  double r = angle - quarters * 1.57079632673412561417;
  r = r - quarters * 6.07710050650619224932e-11;
  if (!(std::abs(r) <= 1.0)) return {kNaN, kNaN};
  const double r2 = r * r;
  double s = r2 * (1.0 / 362880.0) + (-1.0 / 5040.0);
  s = r2 * s + 1.0 / 120.0;
  s = r2 * s + (-1.0 / 6.0);
  s = r2 * s * r + r;
  double c = r2 * (1.0 / 40320.0) + (-1.0 / 720.0);
  c = r2 * c + 1.0 / 24.0;
  c = r2 * c + (-0.5);
  c = r2 * c + 1.0;
  switch (static_cast<int>(std::fmod(std::fmod(quarters, 4.0) + 4.0, 4.0))) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

/// The cell below a point; one outside the map where pose or point is no number or very far away.
Cell twin_cell(const GridFrame& frame, const Pose2& pose, const Eigen::Vector2f& point) {
  constexpr Cell kOutside{-1, -1};
  const double scale = 1.0 / frame.resolution;
  const SinCos turn = twin_sin_cos(pose.yaw);
  const double x = (pose.x - frame.origin.x()) * scale + 0.5;
  const double y = (pose.y - frame.origin.y()) * scale + 0.5;
  if (!(std::abs(x) <= 1e7 && std::abs(y) <= 1e7) || std::isnan(turn.sin)) return kOutside;
  if (!(std::abs(point.x()) <= 1e6F && std::abs(point.y()) <= 1e6F)) return kOutside;
  const auto cos = static_cast<float>(turn.cos * scale);
  const auto sin = static_cast<float>(turn.sin * scale);
  const float at_x = cos * point.x() - sin * point.y() + static_cast<float>(x);
  const float at_y = sin * point.x() + cos * point.y() + static_cast<float>(y);
  const auto whole = [](float at, int cells) {
    const float within = std::min(std::max(at, 0.0F), static_cast<float>(cells + 1));
    return static_cast<int>(std::nearbyint(within)) - 1;
  };
  return {whole(at_x, frame.columns), whole(at_y, frame.rows)};
}

std::vector<double> twin_log_likelihoods(const LikelihoodFieldModel& model,
                                         const std::vector<Pose2>& poses,
                                         const std::vector<Eigen::Vector2f>& points) {
  std::vector<double> out;
  for (const Pose2& pose : poses) {
    int sum = 0;
    for (const auto& point : points) sum += model.cost(twin_cell(model.frame(), pose, point));
    out.push_back(0.0 - model.step() * sum);
  }
  return out;
}

BeamSkipResult twin_skipping(const LikelihoodFieldModel& model, const std::vector<Pose2>& poses,
                             const std::vector<Eigen::Vector2f>& points,
                             const BeamSkipOptions& skip) {
  BeamSkipResult result;
  for (const auto& point : points) {
    int disagreeing = 0;
    for (const Pose2& pose : poses) {
      disagreeing += model.disagrees(twin_cell(model.frame(), pose, point)) ? 1 : 0;
    }
    const bool kept = disagreeing <= skip.max_disagreeing_share * static_cast<double>(poses.size());
    result.kept.push_back(kept ? 1 : 0);
    result.skipped += kept ? 0 : 1;
  }
  if (static_cast<double>(result.skipped) >
      skip.max_skipped_share * static_cast<double>(points.size())) {
    result = {.kept = std::vector<std::uint8_t>(points.size(), 1), .gave_up = true};
  }
  return result;
}

/// Free, with walls and unknown cells strewn in.
Grid<std::int8_t> strewn_map(int columns, int rows, double resolution, Rng& rng) {
  Grid<std::int8_t> map(GridFrame{.origin = {rng.uniform(-5.0, 5.0), rng.uniform(-5.0, 5.0)},
                                  .resolution = resolution,
                                  .columns = columns,
                                  .rows = rows},
                        0);
  for (auto& cell : map.cells()) {
    const double draw = rng.uniform(0.0, 1.0);
    cell = static_cast<std::int8_t>(draw < 0.02 ? 100 : draw < 0.1 ? -1 : 0);
  }
  return map;
}

std::vector<Pose2> poses_about(const GridFrame& frame, int count, Rng& rng) {
  std::vector<Pose2> poses;
  for (int i = 0; i < count; ++i) {
    poses.push_back({frame.origin.x() + rng.uniform(-0.2, 1.2) * frame.columns * frame.resolution,
                     frame.origin.y() + rng.uniform(-0.2, 1.2) * frame.rows * frame.resolution,
                     rng.uniform(-10.0, 10.0)});
  }
  return poses;
}

std::vector<Eigen::Vector2f> points_within(double reach_m, int count, Rng& rng) {
  std::vector<Eigen::Vector2f> points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(rng.uniform(-reach_m, reach_m), rng.uniform(-reach_m, reach_m));
  }
  return points;
}

/// Places for the numbers that break arithmetic, into some poses and points.
void spoil(std::vector<Pose2>& poses, std::vector<Eigen::Vector2f>& points, Rng& rng) {
  for (const double bad : {kNaN, kInf, -kInf, 1e300, -1e18, 1e7, 0.0}) {
    const auto pick = [&](std::size_t size) { return static_cast<std::size_t>(rng.below(size)); };
    if (!poses.empty()) poses[pick(poses.size())].x = bad;
    if (!poses.empty()) poses[pick(poses.size())].y = bad;
    if (!poses.empty()) poses[pick(poses.size())].yaw = bad;
    if (!points.empty()) points[pick(points.size())].x() = static_cast<float>(bad);
    if (!points.empty()) points[pick(points.size())].y() = static_cast<float>(bad);
  }
}

RC_GTEST_PROP(LikelihoodFieldModel, EqualsItsTwinOnEveryInstructionSetForAnyThreads, ()) {
  Rng rng(*rc::gen::arbitrary<std::uint64_t>());
  const int columns = *rc::gen::inRange(1, 60);
  const int rows = *rc::gen::inRange(1, 60);
  const double resolution = *rc::gen::element(0.05, 0.1, 0.03, 1.0);
  const LikelihoodFieldModel model(strewn_map(columns, rows, resolution, rng));
  auto poses = poses_about(model.frame(), *rc::gen::inRange(0, 300), rng);
  auto points = points_within(60 * resolution, *rc::gen::inRange(0, 100), rng);
  if (*rc::gen::arbitrary<bool>()) spoil(poses, points, rng);

  const auto expected = twin_log_likelihoods(model, poses, points);
  on_each_instruction_set([&](const char* name) {
    for (const int threads : {1, 2}) {
      std::vector<double> out(poses.size(), 7.0);
      model.log_likelihoods(poses, points, out, {threads});
      RC_TAG(name);
      RC_ASSERT(out == expected);
    }
  });
}

RC_GTEST_PROP(LikelihoodFieldModel, BeamSkippingEqualsItsTwin, ()) {
  Rng rng(*rc::gen::arbitrary<std::uint64_t>());
  const LikelihoodFieldModel model(strewn_map(50, 40, 0.2, rng), {.agree_distance_m = 0.5});
  auto poses = poses_about(model.frame(), *rc::gen::inRange(1, 60), rng);
  const double cloud = *rc::gen::element(0.02, 0.3, 1.0);  // of the map
  for (Pose2& pose : poses) {
    pose.x *= cloud;
    pose.y *= cloud;
    pose.yaw *= cloud;
  }
  auto points = points_within(5.0, *rc::gen::inRange(0, 70), rng);
  if (*rc::gen::arbitrary<bool>()) spoil(poses, points, rng);
  const BeamSkipOptions skip{.max_disagreeing_share = *test::between(0.0, 1.0),
                             .max_skipped_share = *rc::gen::element(0.1, 0.5, 1.0)};

  const BeamSkipResult expected = twin_skipping(model, poses, points, skip);
  RC_CLASSIFY(expected.skipped > 0);
  RC_CLASSIFY(expected.gave_up);
  std::vector<Eigen::Vector2f> kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (expected.kept[i] != 0) kept.push_back(points[i]);
  }
  const auto expected_out = twin_log_likelihoods(model, poses, kept);
  on_each_instruction_set([&](const char* name) {
    RC_TAG(name);
    for (const int threads : {1, 2}) {
      std::vector<double> out(poses.size(), 7.0);
      const auto result = model.log_likelihoods_skipping(poses, points, out, skip, {threads});
      RC_ASSERT(result.kept == expected.kept);
      RC_ASSERT(result.skipped == expected.skipped);
      RC_ASSERT(result.gave_up == expected.gave_up);
      RC_ASSERT(out == expected_out);
    }
  });
}

TEST(LikelihoodFieldModel, LargeMapsAndLongScansEqualTheTwinToo) {
  Rng rng(3);  // poses are taken in another order than they come, and points in several blocks
  const LikelihoodFieldModel model(strewn_map(700, 600, 0.05, rng));
  const auto poses = poses_about(model.frame(), 700, rng);
  const auto points = points_within(10.0, 2 * static_cast<int>(detail::kAtOnce) + 3, rng);
  const auto expected = twin_log_likelihoods(model, poses, points);
  on_each_instruction_set([&](const char* name) {
    for (const int threads : {1, 2}) {
      std::vector<double> out(poses.size());
      model.log_likelihoods(poses, points, out, {threads});
      EXPECT_EQ(out, expected) << name;
    }
  });
}

TEST(LikelihoodFieldModel, SinesAndCosinesAreExactToAFloat) {
  std::vector<Pose2> poses;
  Rng rng(8);
  for (int i = -64; i <= 64; ++i) poses.push_back({0.0, 0.0, i * kPi / 16.0});
  for (int i = 0; i < 5000; ++i) poses.push_back({0.0, 0.0, rng.uniform(-kPi, kPi)});
  for (int i = 0; i < 5000; ++i) poses.push_back({0.0, 0.0, rng.uniform(-1e6, 1e6)});
  const detail::ByteField field{.cells_per_m = 1.0};
  on_each_instruction_set([&](const char* name) {
    auto arrays = detail::pose_arrays(poses.size());
    detail::prepare_poses(field, poses, 0, poses.size(), arrays);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      ASSERT_NEAR(arrays.sin[i], std::sin(poses[i].yaw), 1e-7) << name << " " << poses[i].yaw;
      ASSERT_NEAR(arrays.cos[i], std::cos(poses[i].yaw), 1e-7) << name << " " << poses[i].yaw;
    }
  });
}

TEST(LikelihoodFieldModel, ValuesAreThoseOfTheMixture) {
  // One wall in the middle of free cells; Thrun 2005, table 6.3.
  Grid<std::int8_t> map(GridFrame{.resolution = 0.05, .columns = 101, .rows = 101}, 0);
  map[{50, 50}] = 100;
  const LikelihoodFieldOptions options{
      .hit_sigma_m = 0.1, .random_share = 0.3, .max_range_m = 20.0, .max_distance_m = 0.35};
  const LikelihoodFieldModel model(map, options);
  const auto log_likelihood = [](double d) {
    return std::log(0.7 / std::sqrt(2.0 * kPi) / 0.1 * std::exp(-0.5 * d * d / 0.01) + 0.3 / 20.0);
  };
  EXPECT_EQ(model.cost({50, 50}), 0);
  for (int column = 0; column < 101; ++column) {
    const double d = std::min(0.35, 0.05 * std::hypot(column - 50, 3.0));
    EXPECT_NEAR(-model.step() * model.cost({column, 53}), log_likelihood(d) - log_likelihood(0.0),
                0.501 * model.step())
        << column;
  }
  EXPECT_EQ(model.cost({0, 0}), 255) << "the whole range of a byte is used";
}

TEST(LikelihoodFieldModel, WhatTheMapDoesNotKnowIsEvenlyLikely) {
  Grid<std::int8_t> map(GridFrame{.resolution = 0.05, .columns = 60, .rows = 60}, -1);
  for (int row = 0; row < 60; ++row) {
    for (int column = 0; column < 30; ++column) map[{column, row}] = 0;
    map[{30, row}] = 100;
  }
  const LikelihoodFieldOptions options{
      .hit_sigma_m = 0.1, .random_share = 0.5, .max_range_m = 30.0};
  const LikelihoodFieldModel model(map, options);
  const double best = std::log(0.5 / std::sqrt(2.0 * kPi) / 0.1 + 0.5 / 30.0);
  for (const Cell cell : {Cell{45, 30}, Cell{59, 0}, Cell{-1, 5}, Cell{5, 60}, Cell{-900, 9000}}) {
    EXPECT_NEAR(-model.step() * model.cost(cell), std::log(1.0 / 30.0) - best,
                0.501 * model.step());
    EXPECT_FALSE(model.disagrees(cell));
  }
  EXPECT_EQ(model.cost({31, 30}), model.cost({29, 30})) << "just behind the wall as just before it";
  EXPECT_GT(model.cost({5, 30}), model.cost({45, 30})) << "free space speaks against, unknown less";
  EXPECT_TRUE(model.disagrees({5, 30}));
  EXPECT_FALSE(model.disagrees({25, 30}));
}

TEST(LikelihoodFieldModel, DistancesThatAreNoNumbersAreUnknown) {
  Grid<float> distances(GridFrame{.resolution = 0.1, .columns = 3, .rows = 1}, 0.0F);
  distances[{1, 0}] = std::numeric_limits<float>::quiet_NaN();
  distances[{2, 0}] = std::numeric_limits<float>::infinity();
  const LikelihoodFieldModel model(distances);
  EXPECT_EQ(model.cost({0, 0}), 0);
  EXPECT_EQ(model.cost({1, 0}), model.cost({-1, 0}));
  EXPECT_EQ(model.cost({2, 0}), 255);
  EXPECT_FALSE(model.disagrees({1, 0}));
  EXPECT_TRUE(model.disagrees({2, 0}));
}

TEST(LikelihoodFieldModel, BeamsOnAPersonAreLeftOut) {
  // A room of 8 x 6 m, seen from its middle; a person stands in front of some beams.
  Grid<std::int8_t> map(GridFrame{.resolution = 0.05, .columns = 160, .rows = 120}, 0);
  for (int column = 0; column < 160; ++column) map[{column, 0}] = map[{column, 119}] = 100;
  for (int row = 0; row < 120; ++row) map[{0, row}] = map[{159, row}] = 100;
  const LikelihoodFieldModel model(map);
  std::vector<Eigen::Vector2f> points;
  for (int i = 0; i < 60; ++i) {
    const double angle = 2.0 * kPi * i / 60.0;
    const double wall =
        std::min(3.975 / std::abs(std::cos(angle)), 2.975 / std::abs(std::sin(angle)));
    const double range = i < 12 ? 1.2 : wall;
    points.emplace_back(range * std::cos(angle), range * std::sin(angle));
  }
  Rng rng(4);
  std::vector<Pose2> poses{{4.0, 3.0, 0.0}};
  while (poses.size() < 500) {
    poses.push_back(
        {4.0 + rng.normal(0.0, 0.1), 3.0 + rng.normal(0.0, 0.1), rng.normal(0.0, 0.05)});
  }
  std::vector<double> all(poses.size());
  std::vector<double> without(poses.size());
  model.log_likelihoods(poses, points, all);
  const BeamSkipResult result = model.log_likelihoods_skipping(poses, points, without);
  EXPECT_EQ(result.skipped, 12U);
  EXPECT_FALSE(result.gave_up);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(result.kept[i], i < 12 ? 0 : 1) << i;
  EXPECT_GT(without[0], all[0] + 12.0);

  const BeamSkipResult strict =
      model.log_likelihoods_skipping(poses, points, without, {.max_skipped_share = 0.1});
  EXPECT_TRUE(strict.gave_up);
  EXPECT_EQ(without, all);
}

TEST(LikelihoodFieldModel, BadUseIsRefused) {
  const Grid<std::int8_t> map(GridFrame{.resolution = 0.05, .columns = 4, .rows = 4}, 0);
  const LikelihoodFieldModel model(map);
  const std::vector<Pose2> poses(3);
  const std::vector<Eigen::Vector2f> points(2, Eigen::Vector2f::Zero());
  std::vector<double> out(2);
  EXPECT_THROW(model.log_likelihoods(poses, points, out), UsageError);
  EXPECT_THROW((void)model.log_likelihoods_skipping(poses, points, out), UsageError);
  EXPECT_THROW(LikelihoodFieldModel(
                   Grid<std::int8_t>(GridFrame{.resolution = 0.0, .columns = 4, .rows = 4}, 0)),
               UsageError);
  EXPECT_THROW(LikelihoodFieldModel(Grid<std::int8_t>(
                   GridFrame{.resolution = 0.05, .columns = (1 << 22) + 1, .rows = 1}, 0)),
               UsageError);
}

}  // namespace
}  // namespace loopstone
