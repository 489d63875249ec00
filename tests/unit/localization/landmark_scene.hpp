#pragma once

#include <cmath>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/localization/landmark_association.hpp"
#include "loopstone/localization/landmark_map.hpp"
#include "loopstone/sensor/landmark_reading.hpp"

// Landmarks around a hall of 20 m, and a robot that looks at them.
namespace loopstone::test {

constexpr double kSceneRangeSigmaM = 0.02;
constexpr double kSceneBearingSigmaRad = 0.004;

/// No two distances alike.
[[nodiscard]] inline LandmarkMap hall_map() {
  return LandmarkMap({{1, {9.0, 0.5}},
                      {2, {7.2, 6.1}},
                      {3, {2.1, 9.3}},
                      {4, {-4.4, 8.1}},
                      {5, {-8.8, 3.0}},
                      {6, {-7.9, -3.7}},
                      {7, {-3.1, -8.6}},
                      {8, {1.4, -5.9}},
                      {9, {6.3, -7.4}},
                      {10, {0.8, 1.9}}});
}

/// Sees the landmarks of these indices, with noise of so many standard deviations.
[[nodiscard]] inline std::vector<LandmarkObservation> seen_from(
    const Pose2& map_T_robot, const LandmarkMap& map, const std::vector<std::size_t>& landmarks,
    bool names, Rng& rng, double noise = 1.0) {
  std::vector<LandmarkObservation> observations;
  for (const std::size_t landmark : landmarks) {
    const Eigen::Vector2d at = map_T_robot.inverse() * map[landmark].position;
    const double range = at.norm() + noise * rng.normal(0.0, kSceneRangeSigmaM);
    const double bearing =
        std::atan2(at.y(), at.x()) + noise * rng.normal(0.0, kSceneBearingSigmaRad);
    observations.push_back(observed(range, bearing, kSceneRangeSigmaM, kSceneBearingSigmaRad));
    if (names) observations.back().id = map[landmark].id;
  }
  return observations;
}

/// Those within a range.
[[nodiscard]] inline std::vector<std::size_t> in_range(const Pose2& map_T_robot,
                                                       const LandmarkMap& map, double range_m) {
  return map.within(map_T_robot.translation(), range_m);
}

[[nodiscard]] inline PoseWithCovariance2 about(const Pose2& pose, double sigma_m,
                                               double sigma_rad) {
  PoseWithCovariance2 belief{.pose = pose};
  belief.covariance.diagonal() << sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad;
  return belief;
}

}  // namespace loopstone::test
