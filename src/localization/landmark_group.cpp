#include "localization/landmark_group.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "localization/landmark_mapping_numbers.hpp"

namespace loopstone {
namespace {

/// Sum of squared sightings about their weighted mean.
double misfit(std::span<const Sighting> sightings, double radius_m, const LandmarkScene& scene,
              std::span<const Pose2> map_T_node) {
  const Eigen::Vector2d centre = place_of(sightings, radius_m, scene, map_T_node).position;
  double chi2 = 0.0;
  for (const Sighting& sighting : sightings) {
    const LandmarkObservation& seen = scene.of(sighting);
    const Pose2& pose = map_T_node[sighting.node];
    const Eigen::Vector2d off = pose.inverse() * centre - centre_of(seen, radius_m);
    chi2 += off.dot(seen.covariance.inverse() * off);
  }
  return chi2;
}

}  // namespace

std::vector<Sighting> sightings_of(const LandmarkGroup& group, const LandmarkScene& scene) {
  std::vector<Sighting> all;
  for (const std::size_t track : group.tracks) {
    const auto& sightings = scene.tracks[track].sightings;
    all.insert(all.end(), sightings.begin(), sightings.end());
  }
  return all;
}

UncertainPoint place_of(std::span<const Sighting> sightings, double radius_m,
                        const LandmarkScene& scene, std::span<const Pose2> map_T_node) {
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Sighting& sighting : sightings) {
    const LandmarkObservation& seen = scene.of(sighting);
    const Pose2& pose = map_T_node[sighting.node];
    const Eigen::Matrix2d turn = pose.rotation();
    const Eigen::Matrix2d weight = (turn * seen.covariance * turn.transpose()).inverse();
    information += weight;
    sum += weight * (pose * centre_of(seen, radius_m));
  }
  const Eigen::Matrix2d covariance = information.inverse();
  return {covariance * sum, 0.5 * (covariance + covariance.transpose())};
}

double baseline_m(std::span<const Sighting> sightings, std::span<const Pose2> map_T_node) {
  double longest = 0.0;
  for (const Sighting& sighting : sightings) {
    const Eigen::Vector2d way = map_T_node[sighting.node].translation() -
                                map_T_node[sightings.front().node].translation();
    longest = std::max(longest, way.norm());
  }
  return longest;
}

double radius_of(std::span<const Sighting> sightings, double radius_max_m,
                 const LandmarkScene& scene, std::span<const Pose2> map_T_node) {
  const double flat = misfit(sightings, 0.0, scene, map_T_node);
  double best = flat;
  double radius = 0.0;
  double from = 0.0;
  double to = radius_max_m;
  for (const double step : {kLandmarkMapping.radius_step_m, 0.1 * kLandmarkMapping.radius_step_m}) {
    const int steps = static_cast<int>(std::floor((to - from) / step));
    for (int i = 0; i <= steps; ++i) {
      const double tried = from + step * i;
      const double chi2 = misfit(sightings, tried, scene, map_T_node);
      if (chi2 >= best) continue;
      best = chi2;
      radius = tried;
    }
    from = std::max(radius - step, 0.0);
    to = std::min(radius + step, radius_max_m);
  }
  // By the noise that is there, not by what is told: it is the same for both shapes.
  const double freedom = std::max(1.0, 2.0 * static_cast<double>(sightings.size()) - 3.0);
  const double noise = std::max(kLandmarkMapping.least_noise, best / freedom);
  return (flat - best) / noise > kLandmarkMapping.round_chi2 ? radius : 0.0;
}

}  // namespace loopstone
