#include "loopstone/localization/landmark_update.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "landmark_scene.hpp"
#include "loopstone/geometry/angle.hpp"
#include "support/generators.hpp"

namespace loopstone {
namespace {

using test::about;
using test::hall_map;
using test::seen_from;

RC_GTEST_PROP(LandmarkUpdate, JacobianIsTheDerivative, ()) {
  const MappedLandmark landmark{1, {20.0, -13.0}};
  const LandmarkObservation seen = observed(5.0, 0.3, 0.1, 0.01);
  const Pose2 pose = *test::any_pose2();
  const LinearSighting linear = linearised(pose, seen, landmark);
  for (int i = 0; i < 3; ++i) {
    constexpr double kStep = 1e-5;
    Eigen::Vector3d low = pose.vector();
    Eigen::Vector3d high = pose.vector();
    low(i) -= kStep;
    high(i) += kStep;
    // What is expected grows where the innovation shrinks.
    const Eigen::Vector2d difference =
        linearised({low.x(), low.y(), low.z()}, seen, landmark).innovation -
        linearised({high.x(), high.y(), high.z()}, seen, landmark).innovation;
    RC_ASSERT((difference / (2.0 * kStep) - linear.jacobian.col(i)).norm() < 1e-5);
  }
}

/// The filter of Kalman as in the books: all innovations at once, one step.
struct OneStep {
  PoseWithCovariance2 posterior{};
  double chi2 = 0.0;
  double log_evidence = 0.0;
};

OneStep extended_kalman(const PoseWithCovariance2& prior, const LandmarkMap& map,
                        const std::vector<LandmarkObservation>& seen,
                        const LandmarkAssociation& association) {
  const auto rows = static_cast<Eigen::Index>(2 * seen.size());
  Eigen::MatrixXd jacobian(rows, 3);
  Eigen::VectorXd innovation(rows);
  Eigen::MatrixXd noise = Eigen::MatrixXd::Zero(rows, rows);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const LinearSighting linear = linearised(prior.pose, seen[i], map[*association[i]]);
    const auto row = static_cast<Eigen::Index>(2 * i);
    jacobian.middleRows<2>(row) = linear.jacobian;
    innovation.segment<2>(row) = linear.innovation;
    noise.block<2, 2>(row, row) = linear.noise;
  }
  const Eigen::MatrixXd spread = jacobian * prior.covariance * jacobian.transpose() + noise;
  const Eigen::MatrixXd gain = prior.covariance * jacobian.transpose() * spread.inverse();
  const Eigen::Vector3d move = gain * innovation;
  OneStep step;
  step.posterior.pose = {prior.pose.x + move.x(), prior.pose.y + move.y(),
                         wrap_angle(prior.pose.yaw + move.z())};
  step.posterior.covariance = (Eigen::Matrix3d::Identity() - gain * jacobian) * prior.covariance;
  step.chi2 = innovation.dot(spread.inverse() * innovation);
  step.log_evidence = -0.5 * (step.chi2 + std::log(spread.determinant()) +
                              static_cast<double>(rows) * std::log(2.0 * kPi));
  return step;
}

TEST(LandmarkUpdate, IsTheExtendedKalmanFilterWhereAllIsLinear) {
  const LandmarkMap map = hall_map();
  Rng rng(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Pose2 truth{rng.uniform(-4.0, 4.0), rng.uniform(-4.0, 4.0), rng.uniform(-kPi, kPi)};
    const auto seen = seen_from(truth, map, {0, 3, 5, 8}, false, rng);
    // So near that no second derivative counts.
    const PoseWithCovariance2 prior = about(
        {truth.x + rng.normal(0.0, 0.003), truth.y + rng.normal(0.0, 0.003), truth.yaw + 0.0005},
        0.005, 0.001);
    const LandmarkAssociation association{0, 3, 5, 8};
    const LandmarkPosterior posterior = update_by_landmarks(prior, map, seen, association);
    const OneStep exact = extended_kalman(prior, map, seen, association);
    EXPECT_EQ(posterior.observations, 4);
    EXPECT_NEAR(posterior.map_T_robot.pose.x, exact.posterior.pose.x, 2e-5);
    EXPECT_NEAR(posterior.map_T_robot.pose.y, exact.posterior.pose.y, 2e-5);
    EXPECT_NEAR(posterior.map_T_robot.pose.yaw, exact.posterior.pose.yaw, 2e-5);
    EXPECT_LT((posterior.map_T_robot.covariance - exact.posterior.covariance).norm(),
              0.01 * exact.posterior.covariance.norm());
    EXPECT_NEAR(posterior.chi2, exact.chi2, 0.02 * exact.chi2 + 0.01);
    EXPECT_NEAR(posterior.log_evidence, exact.log_evidence, 0.02 * exact.chi2 + 0.02);
  }
}

/// Mean, covariance and evidence by adding up the densities of a grid of poses.
struct GridIntegral {
  Pose2 mean{};
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double log_evidence = 0.0;
};

GridIntegral integrated(const PoseWithCovariance2& prior, const LandmarkMap& map,
                        const std::vector<LandmarkObservation>& seen,
                        const LandmarkAssociation& association, const PoseWithCovariance2& centre) {
  const auto log_normal = [](const auto& off, const auto& covariance) {
    return -0.5 * (off.dot(covariance.inverse() * off) + std::log(covariance.determinant()) +
                   static_cast<double>(off.size()) * std::log(2.0 * kPi));
  };
  constexpr int kSteps = 24;
  constexpr double kSigmas = 5.0;
  const Eigen::Vector3d step = kSigmas / kSteps * centre.covariance.diagonal().cwiseSqrt();
  double sum = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  for (int i = -kSteps; i <= kSteps; ++i) {
    for (int j = -kSteps; j <= kSteps; ++j) {
      for (int k = -kSteps; k <= kSteps; ++k) {
        const Eigen::Vector3d off = step.cwiseProduct(Eigen::Vector3d(i, j, k));
        const Pose2 pose{centre.pose.x + off.x(), centre.pose.y + off.y(),
                         centre.pose.yaw + off.z()};
        const Eigen::Vector3d from_prior = pose.vector() - prior.pose.vector();
        double log_density = log_normal(from_prior, prior.covariance);
        for (std::size_t n = 0; n < seen.size(); ++n) {
          const Eigen::Vector2d expected = pose.inverse() * map[*association[n]].position;
          log_density += log_normal(Eigen::Vector2d(seen[n].point - expected), seen[n].covariance);
        }
        const double weight = std::exp(log_density);
        sum += weight;
        mean += weight * off;
        square += weight * off * off.transpose();
      }
    }
  }
  mean /= sum;
  return {{centre.pose.x + mean.x(), centre.pose.y + mean.y(), centre.pose.yaw + mean.z()},
          square / sum - mean * mean.transpose(),
          std::log(sum * step.prod())};
}

TEST(LandmarkUpdate, AgreesWithAddingUpAllPoses) {
  const LandmarkMap map = hall_map();
  Rng rng(2);
  for (int trial = 0; trial < 6; ++trial) {
    const Pose2 truth{rng.uniform(-3.0, 3.0), rng.uniform(-3.0, 3.0), rng.uniform(-2.0, 2.0)};
    const auto seen = seen_from(truth, map, {1, 4, 7}, false, rng);
    // A wide prior: one step of the filter would land decimetres beside.
    const PoseWithCovariance2 prior =
        about({truth.x + 0.4, truth.y - 0.3, truth.yaw + 0.25}, 0.5, 0.3);
    const LandmarkAssociation association{1, 4, 7};
    const LandmarkPosterior posterior = update_by_landmarks(prior, map, seen, association);
    const GridIntegral exact = integrated(prior, map, seen, association, posterior.map_T_robot);
    const Eigen::Vector3d sigma = exact.covariance.diagonal().cwiseSqrt();
    EXPECT_NEAR(posterior.map_T_robot.pose.x, exact.mean.x, 0.05 * sigma.x());
    EXPECT_NEAR(posterior.map_T_robot.pose.y, exact.mean.y, 0.05 * sigma.y());
    EXPECT_NEAR(posterior.map_T_robot.pose.yaw, exact.mean.yaw, 0.05 * sigma.z());
    EXPECT_LT((posterior.map_T_robot.covariance - exact.covariance).norm(),
              0.05 * exact.covariance.norm());
    EXPECT_NEAR(posterior.log_evidence, exact.log_evidence, 0.05);
    const OneStep one = extended_kalman(prior, map, seen, association);
    EXPECT_GT((one.posterior.pose.translation() - truth.translation()).norm(), 0.05)
        << "else this tests nothing that one step has not";
  }
}

TEST(LandmarkUpdate, NothingSeenChangesNothing) {
  const LandmarkMap map = hall_map();
  Rng rng(3);
  const PoseWithCovariance2 prior = about({1.0, 2.0, 0.5}, 0.3, 0.1);
  const auto seen = seen_from(prior.pose, map, {0, 1}, false, rng);
  const LandmarkPosterior posterior =
      update_by_landmarks(prior, map, seen, {std::nullopt, std::nullopt});
  EXPECT_EQ(posterior.map_T_robot.pose, prior.pose);
  EXPECT_EQ(posterior.map_T_robot.covariance, prior.covariance);
  EXPECT_EQ(posterior.log_evidence, 0.0);
  EXPECT_EQ(posterior.observations, 0);
}

TEST(LandmarkUpdate, ALandmarkKnownBadlyTellsLess) {
  Rng rng(4);
  const LandmarkMap sure({{1, {5.0, 0.0}}});
  const LandmarkMap unsure({{1, {5.0, 0.0}, 0.3}});
  const auto seen = seen_from({}, sure, {0}, false, rng);
  const PoseWithCovariance2 prior = about({}, 0.5, 0.01);
  const auto by_sure = update_by_landmarks(prior, sure, seen, {0}).map_T_robot.covariance;
  const auto by_unsure = update_by_landmarks(prior, unsure, seen, {0}).map_T_robot.covariance;
  // Along the beam: 1 / (1 / 0.5^2 + 1 / (0.02^2 + sigma^2)).
  EXPECT_NEAR(by_sure(0, 0), 1.0 / (4.0 + 1.0 / 0.0004), 1e-6);
  EXPECT_NEAR(by_unsure(0, 0), 1.0 / (4.0 + 1.0 / (0.0004 + 0.09)), 1e-4);
}

TEST(LandmarkUpdate, APostIsAsFarAsItsCentre) {
  const LandmarkMap post({{1, {5.0, 0.0}, 0.0, 0.1}});
  LandmarkObservation seen = observed(4.9, 0.0, 0.01, 0.001);
  seen.beams_beside_m = {0.0};
  const auto posterior =
      update_by_landmarks(about({0.2, 0.0, 0.0}, 0.5, 0.001), post, std::span(&seen, 1), {0});
  EXPECT_NEAR(posterior.map_T_robot.pose.x, 0.0, 1e-3);
}

}  // namespace
}  // namespace loopstone
