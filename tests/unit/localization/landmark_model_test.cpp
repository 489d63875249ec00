#include "loopstone/localization/landmark_model.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>

#include "landmark_drive.hpp"
#include "localization/assignment.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/geometry/angle.hpp"
#include "support/generators.hpp"

namespace loopstone {
namespace {

/// The best sum of gains, by trying everything.
double best_gain(const GainTable& table, std::size_t row, std::vector<bool>& taken) {
  if (row == table.rows) return 0.0;
  double best = best_gain(table, row + 1, taken);
  for (std::size_t column = 0; column < table.columns; ++column) {
    if (taken[column]) continue;
    taken[column] = true;
    best = std::max(best, table.at(row, column) + best_gain(table, row + 1, taken));
    taken[column] = false;
  }
  return best;
}

RC_GTEST_PROP(BestAssignment, AgreesWithTryingEverything, ()) {
  GainTable table;
  table.rows = *rc::gen::inRange<std::size_t>(0, 5);
  table.columns = *rc::gen::inRange<std::size_t>(0, 6);
  // Few different values, so that ties and conflicts are common; and any.
  const auto gain =
      rc::gen::oneOf(rc::gen::element(-1.0, 0.0, 1.0, 2.0, 3.0), test::between(-2.0, 5.0));
  table.gains = *rc::gen::container<std::vector<double>>(table.rows * table.columns, gain);
  const auto assignment = best_assignment(table);
  RC_ASSERT(assignment.size() == table.rows);
  std::vector<bool> taken(table.columns, false);
  double sum = 0.0;
  for (std::size_t row = 0; row < table.rows; ++row) {
    if (!assignment[row]) continue;
    RC_ASSERT(!taken[*assignment[row]]);
    taken[*assignment[row]] = true;
    RC_ASSERT(table.at(row, *assignment[row]) > 0.0);
    sum += table.at(row, *assignment[row]);
  }
  std::vector<bool> none(table.columns, false);
  RC_ASSERT(std::abs(sum - best_gain(table, 0, none)) < 1e-9);
}

RC_GTEST_PROP(LandmarkModel, JacobianIsTheDerivative, ()) {
  const LandmarkModel model({{1, {20.0, -13.0}}}, {});
  const Pose2 pose = *test::any_pose2();
  const auto analytic = model.jacobian(pose, 0);
  for (int i = 0; i < 3; ++i) {
    constexpr double kStep = 1e-5;
    Eigen::Vector3d low = pose.vector();
    Eigen::Vector3d high = pose.vector();
    low(i) -= kStep;
    high(i) += kStep;
    // innovation(low) of what is expected at high is the wrapped difference.
    const LandmarkSighting at_high = model.expected({high.x(), high.y(), high.z()}, 0);
    const Eigen::Vector2d difference = model.innovation({low.x(), low.y(), low.z()}, at_high, 0);
    RC_ASSERT((difference / (2.0 * kStep) - analytic.col(i)).norm() < 1e-5);
  }
}

TEST(LandmarkModel, LikelihoodIsADensity) {
  LandmarkSensor sensor;
  sensor.range_sigma_m = 0.5;
  sensor.bearing_sigma_rad = 0.2;
  sensor.clutter_share = 0.3;
  const LandmarkModel model({{1, {5.0, 0.0}}}, sensor);
  double sum = 0.0;
  constexpr double kRangeStep = 0.05;
  constexpr double kBearingStep = 0.02;
  for (double range = 0.5 * kRangeStep; range < sensor.max_range_m; range += kRangeStep) {
    for (double bearing = -kPi + 0.5 * kBearingStep; bearing < kPi; bearing += kBearingStep) {
      const LandmarkSighting sighting{range, bearing, 1};
      sum +=
          std::exp(model.log_likelihood({}, std::span(&sighting, 1))) * kRangeStep * kBearingStep;
    }
  }
  EXPECT_NEAR(sum, 1.0, 0.01);
}

TEST(LandmarkModel, NoLandmarkIsSeenTwice) {
  const LandmarkModel model({{1, {5.0, 0.0}}, {2, {5.0, 0.3}}}, {});
  // Both are nearest to landmark 1; the second best of one of them is landmark 2.
  const std::vector<LandmarkSighting> sightings{{5.0, 0.0, {}}, {5.0, 0.02, {}}};
  const auto association = model.associate({}, sightings);
  EXPECT_EQ(association[0], 0U);
  EXPECT_EQ(association[1], 1U);
  const std::vector<LandmarkSighting> thrice{{5.0, 0.0, {}}, {5.0, 0.03, {}}, {5.0, 0.06, {}}};
  const auto crowded = model.associate({}, thrice);
  EXPECT_EQ(std::count(crowded.begin(), crowded.end(), std::nullopt), 1)
      << "one of three is clutter";
  // A name takes the landmark from those without.
  const std::vector<LandmarkSighting> named{{5.0, 0.01, {}}, {5.0, 0.0, 1}};
  EXPECT_EQ(model.associate({}, named)[0], 1U);
}

TEST(LandmarkModel, FarSightingsAreClutter) {
  const LandmarkModel model({{1, {5.0, 0.0}}}, {});
  const std::vector<LandmarkSighting> sightings{{7.0, 0.0, {}}, {5.0, 2.0, 1}, {5.0, 0.0, 99}};
  for (const auto& landmark : model.associate({}, sightings)) EXPECT_FALSE(landmark.has_value());
  EXPECT_NEAR(model.log_likelihood({}, sightings), 3.0 * model.log_clutter(), 1e-9);
  EXPECT_EQ(model.log_likelihood({}, {}), 0.0);
}

TEST(LandmarkModel, NamesAndLooksAgreeWhereThereIsNoDoubt) {
  const LandmarkModel model(test::hall_landmarks(), {});
  Rng rng(4);
  const Pose2 truth{1.0, 2.5, 0.4};
  auto sightings = test::look_around(model, truth, {.clutter_share = 0.0}, true, rng);
  const double named = model.log_likelihood(truth, sightings);
  for (LandmarkSighting& sighting : sightings) sighting.id.reset();
  EXPECT_NEAR(model.log_likelihood(truth, sightings), named, 0.1);
}

TEST(LandmarkModel, SampledPosesSeeTheSighting) {
  const LandmarkModel model(test::hall_landmarks(), {});
  Rng rng(4);
  const LandmarkSighting sighting{4.0, 1.0, 3};
  double chi2 = 0.0;
  constexpr int kDraws = 2000;
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Vector2d off = model.innovation(model.sample_pose(sighting, rng), sighting, 2);
    chi2 += (std::pow(off.x() / 0.1, 2) + std::pow(off.y() / 0.035, 2)) / kDraws;
  }
  EXPECT_NEAR(chi2, 2.0, 0.25);
  EXPECT_THROW((void)model.sample_pose({4.0, 1.0, 77}, rng), UsageError);
}

TEST(LandmarkModel, RefusesNonsense) {
  EXPECT_THROW(LandmarkModel({{1, {0.0, 0.0}}, {1, {1.0, 0.0}}}, {}), UsageError);
  EXPECT_THROW(LandmarkModel({{1, {std::nan(""), 0.0}}}, {}), UsageError);
  EXPECT_THROW(LandmarkModel({}, {.range_sigma_m = 0.0}), UsageError);
  EXPECT_THROW(LandmarkModel({}, {.clutter_share = 0.0}), UsageError);
}

}  // namespace
}  // namespace loopstone
