#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/localization/landmark_map.hpp"
#include "loopstone/sensor/landmark_reading.hpp"

namespace loopstone {

/// Which landmark, by index, each observation is of; nothing: of none.
using LandmarkAssociation = std::vector<std::optional<std::size_t>>;

/// An observation, linearised about a pose: z = R(yaw)^T (m - t) + noise, z the centre of the
/// landmark in the robot frame.
struct LinearSighting {
  Eigen::Vector2d innovation = Eigen::Vector2d::Zero();  ///< seen less expected [m]
  Eigen::Matrix<double, 2, 3> jacobian = Eigen::Matrix<double, 2, 3>::Zero();  ///< of the expected
  /// Of the noise: the sensor's and the landmark's own [m^2].
  Eigen::Matrix2d noise = Eigen::Matrix2d::Zero();
};
[[nodiscard]] LinearSighting linearised(const Pose2& map_T_robot,
                                        const LandmarkObservation& observation,
                                        const MappedLandmark& landmark);

/// A pose after a reading.
struct LandmarkPosterior {
  PoseWithCovariance2 map_T_robot{};
  /// What prior and observations could not agree on: the smallest of |x - prior|^2 / P + sum |z -
  /// h(x)|^2 / R; where all is linear, v^T S^-1 v of all innovations together. Chi-square of 2
  /// degrees of freedom an observation, if prior and noises are right.
  double chi2 = 0.0;
  double log_evidence = 0.0;  ///< log p(observations | prior), a density over [m^2] for each
  int observations = 0;       ///< that are of a landmark
};

/// Takes observations of known landmarks into a pose: the iterated Kalman filter, Gauss-Newton on
/// the posterior density; covariance and evidence are of the normal distribution about its peak
/// (Laplace's approximation), exact where the heading is known well.
/// \param prior        with a covariance that can be inverted
/// \param association  of each observation
/// Cost: O(observations). Source: Bell and Cathey 1993, "The iterated Kalman filter update as a
/// Gauss-Newton method"; MacKay 2003, chapter 27.
[[nodiscard]] LandmarkPosterior update_by_landmarks(
    const PoseWithCovariance2& prior, const LandmarkMap& map,
    std::span<const LandmarkObservation> observations, const LandmarkAssociation& association);

}  // namespace loopstone
