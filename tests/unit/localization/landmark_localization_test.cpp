#include "loopstone/localization/landmark_localization.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>

#include "landmark_drive.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

using test::drive;
using test::DriveOptions;
using test::DriveStep;
using test::hall_landmarks;

bool ever_inconsistent(const std::vector<DriveStep>& steps) {
  return std::any_of(steps.begin(), steps.end(), [](const DriveStep& step) {
    return step.estimate.status == FilterStatus::kInconsistent;
  });
}

/// Share of the second half's steps with that status.
double late_share(const std::vector<DriveStep>& steps, FilterStatus status) {
  const auto half = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  return static_cast<double>(
             std::count_if(half, steps.end(),
                           [&](const DriveStep& step) { return step.estimate.status == status; })) /
         static_cast<double>(steps.end() - half);
}

/// Squared Mahalanobis length of the error: 3 on average for a filter that knows how good it is.
double mean_nees(const std::vector<DriveStep>& steps) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = steps.size() / 2; i < steps.size(); ++i) {
    const Eigen::Vector3d error = steps[i].error();
    sum += error.dot(steps[i].estimate.map_T_robot.covariance.ldlt().solve(error));
    ++count;
  }
  return sum / count;
}

void expect_convergence(const DriveOptions& options, std::uint64_t first_seed, int seeds) {
  double nees = 0.0;
  for (int i = 0; i < seeds; ++i) {
    const auto steps = drive(options, first_seed + static_cast<std::uint64_t>(i));
    SCOPED_TRACE("seed " + std::to_string(first_seed + static_cast<std::uint64_t>(i)));
    for (std::size_t k = steps.size() / 2; k < steps.size(); ++k) {
      EXPECT_LT(steps[k].error_m(), 0.25);
      EXPECT_LT(std::abs(steps[k].error().z()), radians(5.0));
    }
    EXPECT_GE(late_share(steps, FilterStatus::kConverged), 0.9);
    nees += mean_nees(steps) / seeds;
  }
  // 3 is right; errors of neighbouring steps go together, so the mean of a few runs still scatters.
  EXPECT_GT(nees, 2.0);
  EXPECT_LT(nees, 4.5);
}

TEST(LandmarkLocalizer, ConvergesWhenSightingsHaveNames) { expect_convergence({}, 100, 5); }

TEST(LandmarkLocalizer, ConvergesWhenLandmarksLookAlike) {
  DriveOptions options;
  options.names = false;
  options.particles = 400;
  expect_convergence(options, 200, 3);
}

TEST(LandmarkLocalizer, ConvergesFromAnywhere) {
  DriveOptions options;
  options.from_anywhere = true;
  options.particles = 1500;
  expect_convergence(options, 300, 3);
}

TEST(LandmarkLocalizer, DoesNotDoubtItselfWhenAllIsWell) {
  DriveOptions options;
  options.particles = 400;
  options.steps = 40;
  int alarms = 0;
  for (std::uint64_t seed = 1000; seed < 1100; ++seed)
    alarms += ever_inconsistent(drive(options, seed)) ? 1 : 0;
  EXPECT_EQ(alarms, 0) << "of 100 drives";
}

struct Failure {
  std::string name;
  DriveOptions options;
};

std::vector<Failure> failures() {
  std::vector<Failure> all;
  DriveOptions scale;
  scale.faults.range_scale = 1.15;
  all.push_back({"ranges 15 % too long", scale});
  DriveOptions noise;
  noise.faults.noise_scale = 2.5;
  all.push_back({"noise 2.5 times what the model says", noise});
  DriveOptions clutter;
  clutter.faults.clutter_share = 0.5;
  all.push_back({"half of the sightings are of nothing", clutter});
  DriveOptions swapped;
  std::swap(swapped.believed[4].position, swapped.believed[8].position);
  std::swap(swapped.believed[1].position, swapped.believed[6].position);
  all.push_back({"two pairs of landmarks are swapped on the map", swapped});
  DriveOptions wrong;
  for (Landmark& landmark : wrong.believed) landmark.position.x() = -landmark.position.x();
  all.push_back({"the map is mirrored", wrong});
  DriveOptions nameless = wrong;
  nameless.names = false;
  nameless.particles = 250;
  all.push_back({"the map is mirrored and landmarks look alike", nameless});
  DriveOptions carried;
  carried.carried_off_at = 30;
  all.push_back({"the robot is carried off", carried});
  return all;
}

TEST(LandmarkLocalizer, ReportsItsOwnFailure) {
  for (const Failure& failure : failures()) {
    for (std::uint64_t seed = 400; seed < 402; ++seed) {
      const auto steps = drive(failure.options, seed);
      SCOPED_TRACE(failure.name + ", seed " + std::to_string(seed));
      EXPECT_GT(late_share(steps, FilterStatus::kInconsistent), 0.5);
      // Never believed while far off, but for the readings that it takes to notice being carried
      // away.
      EXPECT_LE(std::count_if(steps.begin(), steps.end(),
                              [](const DriveStep& step) {
                                return step.error_m() > 0.5 &&
                                       step.estimate.status == FilterStatus::kConverged;
                              }),
                failure.options.carried_off_at >= 0 ? 3 : 0);
      const LandmarkEstimate& last = steps.back().estimate;
      EXPECT_EQ(reason(last.health).empty(), last.status != FilterStatus::kInconsistent);
    }
  }
}

TEST(LandmarkLocalizer, TooFewParticlesAreReported) {
  Rng rng(1);
  LandmarkSensor sharp;
  sharp.range_sigma_m = 0.003;
  sharp.bearing_sigma_rad = 0.001;
  const LandmarkModel model(hall_landmarks(), sharp);
  const Pose2 truth{4.0, 0.0, 0.0};
  std::vector<Pose2> first(100);
  for (Pose2& pose : first)
    pose = {truth.x + rng.normal(0.0, 0.1), rng.normal(0.0, 0.1), rng.normal(0.0, 0.02)};
  LandmarkLocalizer localizer(model, first, {}, 3);
  LandmarkEstimate estimate;
  for (int step = 0; step < 10; ++step) {
    localizer.predict([](const Pose2& pose, Rng& noise) {
      return Pose2{pose.x + noise.normal(0.0, 0.1), pose.y + noise.normal(0.0, 0.1),
                   pose.yaw + noise.normal(0.0, 0.02)};
    });
    estimate = localizer.update(test::look_around(model, truth, {.clutter_share = 0.0}, true, rng));
  }
  EXPECT_EQ(estimate.status, FilterStatus::kInconsistent);
}

TEST(LandmarkLocalizer, IsTheSameForAnyNumberOfThreads) {
  const LandmarkModel model(hall_landmarks(), {});
  const auto run = [&](Threads threads) {
    Rng rng(6);
    std::vector<Pose2> first(700);
    for (Pose2& pose : first) pose = {rng.normal(4.0), rng.normal(), rng.normal(1.0, 0.2)};
    LandmarkLocalizer localizer(model, first, {}, 3, threads);
    LandmarkEstimate estimate;
    for (int step = 0; step < 5; ++step) {
      localizer.predict([](const Pose2& pose, Rng& noise) {
        return Pose2{pose.x + noise.normal(0.0, 0.1), pose.y, pose.yaw};
      });
      estimate = localizer.update(test::look_around(model, {4.0, 0.0, 1.0}, {}, false, rng));
    }
    return estimate;
  };
  const LandmarkEstimate one = run({1});
  const LandmarkEstimate four = run({4});
  EXPECT_EQ(one.map_T_robot.pose, four.map_T_robot.pose);
  EXPECT_EQ(one.step.log_evidence, four.step.log_evidence);
}

TEST(LandmarkLocalizer, LeavesOutSightingsThatAreNone) {
  LandmarkLocalizer localizer(LandmarkModel(hall_landmarks(), {}),
                              {{4.0, 0.0, 0.0}, {4.1, 0.0, 0.0}}, {}, 1);
  const double nan = std::nan("");
  const std::vector<LandmarkSighting> none{
      {nan, 0.0, 1}, {1.0, nan, 1}, {-1.0, 0.0, 1}, {INFINITY, 0.0, 1}};
  const LandmarkEstimate estimate = localizer.update(none);
  EXPECT_EQ(estimate.sightings, 0);
  EXPECT_EQ(estimate.step.log_evidence, 0.0);
}

// Where prior and sensor are normal, chi2 has its mean and the expected evidence is the mean of the
// evidence.
TEST(CompareWithPrediction, ExpectsWhatHappens) {
  LandmarkSensor sensor;
  sensor.clutter_share = 1e-6;
  const LandmarkModel model({{1, {5.0, 1.0}}, {2, {-1.0, 6.0}}}, sensor);
  Rng rng(9);
  PoseWithCovariance2 prior;
  prior.covariance.diagonal() << 0.01, 0.0025, 0.0004;
  constexpr int kDraws = 4000;
  double chi2 = 0.0;
  double surprise = 0.0;
  double surprise2 = 0.0;
  double variance = 0.0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const Pose2 truth{rng.normal(0.0, 0.1), rng.normal(0.0, 0.05), rng.normal(0.0, 0.02)};
    const auto sightings = test::look_around(model, truth, {.clutter_share = 0.0}, true, rng);
    const std::vector<std::optional<std::size_t>> association{0, 1};
    const FilterReading reading = compare_with_prediction(model, prior, sightings, association);
    // -1/2 chi2 - 1/2 log|2 pi S|: the evidence of a normal prior, from the reading's own terms.
    const double evidence = reading.expected_log_evidence + 0.5 * (4.0 - reading.innovation_chi2);
    chi2 += reading.innovation_chi2 / kDraws;
    surprise += (evidence - reading.expected_log_evidence) / kDraws;
    surprise2 += std::pow(evidence - reading.expected_log_evidence, 2) / kDraws;
    variance = reading.log_evidence_variance;
    ASSERT_LE(reading.innovation_freedom, 4);
  }
  EXPECT_NEAR(chi2, 4.0, 0.25);
  EXPECT_NEAR(surprise, 0.0, 0.15);
  EXPECT_NEAR(surprise2, variance, 0.3);
}

// The expected evidence against the one that a particle filter finds.
TEST(CompareWithPrediction, AgreesWithTheParticles) {
  const LandmarkSensor sensor;
  const LandmarkModel model({{1, {5.0, 1.0}}, {2, {-1.0, 6.0}}, {3, {-3.0, -3.0}}}, sensor);
  Rng rng(9);
  PoseWithCovariance2 prior;
  prior.covariance.diagonal() << 0.01, 0.0025, 0.0004;
  std::vector<Pose2> states(2000);
  for (Pose2& pose : states)
    pose = {rng.normal(0.0, 0.1), rng.normal(0.0, 0.05), rng.normal(0.0, 0.02)};
  const ParticleFilter<Pose2> belief(states);
  constexpr int kDraws = 150;
  double surprise = 0.0;
  double variance = 0.0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const Pose2 truth{rng.normal(0.0, 0.1), rng.normal(0.0, 0.05), rng.normal(0.0, 0.02)};
    const auto sightings =
        test::look_around(model, truth, {.clutter_share = sensor.clutter_share}, true, rng);
    ParticleFilter<Pose2> filter = belief;
    const double evidence =
        filter.update([&](const Pose2& pose) { return model.log_likelihood(pose, sightings); });
    const FilterReading reading =
        compare_with_prediction(model, prior, sightings, model.associate(truth, sightings));
    surprise += (evidence - reading.expected_log_evidence) / kDraws;
    variance += reading.log_evidence_variance / kDraws;
  }
  EXPECT_NEAR(surprise, 0.0, 4.0 * std::sqrt(variance / kDraws));
}

}  // namespace
}  // namespace loopstone
