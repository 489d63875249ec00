#include "loopstone/localization/landmark_localization.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/localization/weighted_moments.hpp"

namespace loopstone {

namespace {

std::vector<LandmarkSighting> usable(std::span<const LandmarkSighting> sightings) {
  std::vector<LandmarkSighting> kept;
  for (const LandmarkSighting& sighting : sightings) {
    if (sighting.range_m > 0.0 && std::isfinite(sighting.range_m) &&
        std::isfinite(sighting.bearing_rad)) {
      kept.push_back(sighting);
    }
  }
  return kept;
}

/// Log of the determinant of 2 pi S, by the factor of S.
double log_determinant_2pi(const Eigen::LLT<Eigen::MatrixXd>& factor) {
  const Eigen::MatrixXd& lower = factor.matrixLLT();
  return 2.0 * lower.diagonal().array().log().sum() +
         static_cast<double>(lower.rows()) * std::log(2.0 * kPi);
}

}  // namespace

FilterReading compare_with_prediction(const LandmarkModel& model, const PoseWithCovariance2& prior,
                                      std::span<const LandmarkSighting> sightings,
                                      std::span<const std::optional<std::size_t>> association) {
  const LandmarkSensor& sensor = model.sensor();
  const Eigen::Vector2d noise(sensor.range_sigma_m * sensor.range_sigma_m,
                              sensor.bearing_sigma_rad * sensor.bearing_sigma_rad);
  // Sightings of one reading share the error of the pose, so they are judged together:
  // chi2 = v^T S^-1 v with v all innovations, S = H P H^T + R.
  std::vector<Eigen::Vector2d> innovations;
  std::vector<Eigen::Matrix<double, 2, 3>> jacobians;
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    if (!association[i]) continue;
    const Eigen::Vector2d innovation = model.innovation(prior.pose, sightings[i], *association[i]);
    const Eigen::Matrix<double, 2, 3> jacobian = model.jacobian(prior.pose, *association[i]);
    Eigen::Matrix2d spread = jacobian * prior.covariance * jacobian.transpose();
    spread.diagonal() += noise;
    if (innovation.dot(spread.llt().solve(innovation)) > sensor.gate_chi2) continue;
    innovations.push_back(innovation);
    jacobians.push_back(jacobian);
  }
  const auto explained = static_cast<Eigen::Index>(innovations.size());
  FilterReading reading;
  // The normal part of one sighting's expected log density: -1/2 log|2 pi S| - 1, of all sightings
  // on average.
  double normal_part = -0.5 * std::log(4.0 * kPi * kPi * noise.x() * noise.y()) - 1.0;
  if (explained > 0) {
    Eigen::VectorXd all(2 * explained);
    Eigen::MatrixXd by_pose(2 * explained, 3);
    for (Eigen::Index k = 0; k < explained; ++k) {
      all.segment<2>(2 * k) = innovations[static_cast<std::size_t>(k)];
      by_pose.middleRows<2>(2 * k) = jacobians[static_cast<std::size_t>(k)];
    }
    Eigen::MatrixXd spread = by_pose * prior.covariance * by_pose.transpose();
    spread.diagonal() += noise.replicate(explained, 1);
    const Eigen::LLT<Eigen::MatrixXd> factor(spread);
    reading.innovation_chi2 = all.dot(factor.solve(all));
    reading.innovation_freedom = static_cast<int>(2 * explained);
    normal_part = -0.5 * log_determinant_2pi(factor) / static_cast<double>(explained) - 1.0;
  }
  // A sighting is clutter with probability c, else normal; -chi2/2 of two numbers has the variance
  // 1.
  const double clutter = sensor.clutter_share;
  const double of_landmark = std::log(1.0 - clutter) + normal_part;
  const double gap = of_landmark - model.log_clutter();
  const auto count = static_cast<double>(sightings.size());
  reading.expected_log_evidence =
      count * ((1.0 - clutter) * of_landmark + clutter * model.log_clutter());
  reading.log_evidence_variance = count * (1.0 - clutter) * (1.0 + clutter * gap * gap);
  reading.log_evidence_jump = std::max(0.0, gap);
  return reading;
}

LandmarkLocalizer::LandmarkLocalizer(LandmarkModel model, std::vector<Pose2> first_poses,
                                     LandmarkLocalizerOptions options, std::uint64_t seed,
                                     Threads threads)
    : model_(std::move(model)),
      options_(std::move(options)),
      filter_(std::move(first_poses)),
      monitor_(options_.health),
      rng_(seed),
      threads_(threads) {}

bool LandmarkLocalizer::narrow(const PoseWithCovariance2& belief) const {
  const Eigen::Matrix3d& covariance = belief.covariance;
  return covariance(0, 0) + covariance(1, 1) < 2.0 * options_.narrow_m * options_.narrow_m &&
         covariance(2, 2) < options_.narrow_rad * options_.narrow_rad;
}

void LandmarkLocalizer::predict(
    const std::function<Pose2(const Pose2& map_T_before, Rng& noise)>& motion) {
  filter_.predict(motion, rng_, threads_);
}

LandmarkEstimate LandmarkLocalizer::update(std::span<const LandmarkSighting> sightings) {
  const std::vector<LandmarkSighting> seen = usable(sightings);
  const PoseWithCovariance2 prior = weighted_moments(filter_.states(), filter_.weights());
  const double log_evidence = filter_.update(
      [&](const Pose2& map_T_robot) { return model_.log_likelihood(map_T_robot, seen); }, threads_);

  LandmarkEstimate estimate;
  estimate.map_T_robot = weighted_moments(filter_.states(), filter_.weights());
  const auto association = model_.associate(estimate.map_T_robot.pose, seen);
  estimate.sightings = static_cast<int>(seen.size());
  estimate.explained =
      static_cast<int>(std::count_if(association.begin(), association.end(),
                                     [](const auto& landmark) { return landmark.has_value(); }));
  // While the belief is wide, or has several places, no normal distribution predicts the reading.
  if (!seen.empty() && narrow(prior)) {
    FilterReading reading = compare_with_prediction(model_, prior, seen, association);
    reading.log_evidence = log_evidence;
    reading.effective_share = filter_.effective_sample_size() / static_cast<double>(filter_.size());
    monitor_.add(reading);
  }
  estimate.health = monitor_.judge();
  if (estimate.health.doubt != FilterDoubt::kNone) {
    estimate.status = FilterStatus::kInconsistent;
  } else if (narrow(estimate.map_T_robot) &&
             estimate.health.readings >= options_.health.min_readings &&
             monitor_.judge(options_.confirm_quantile).doubt == FilterDoubt::kNone) {
    // Narrow alone is not enough: particles that are few and wrong are narrow too, until readings
    // contradict them.
    estimate.status = FilterStatus::kConverged;
  }
  estimate.step = renew(filter_, options_.renewal, log_evidence, rng_);
  return estimate;
}

}  // namespace loopstone
