#include "localization/landmark_group.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "localization/landmark_mapping_numbers.hpp"

namespace loopstone {
namespace {

/// Sum of squares by which the beams of a sighting miss the best straight line, however it faces.
double line_misfit(const LandmarkObservation& seen) {
  const std::vector<double>& x = seen.beams_beyond_m;
  const std::vector<double>& y = seen.beams_beside_m;
  const double mean = std::reduce(y.begin(), y.end()) / static_cast<double>(y.size());
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {  // the mean of x is 0
    xx += x[i] * x[i];
    xy += x[i] * (y[i] - mean);
    yy += (y[i] - mean) * (y[i] - mean);
  }
  return yy > 0.0 ? xx - xy * xy / yy : xx;
}

/// The same of a circle that faces the sensor, as all do.
double circle_misfit(const LandmarkObservation& seen, double radius_m) {
  double depth_m = 0.0;
  std::vector<double> depths_m;
  for (const double beside : seen.beams_beside_m) {
    depths_m.push_back(std::sqrt(std::max(0.0, radius_m * radius_m - beside * beside)));
    depth_m += depths_m.back() / static_cast<double>(seen.beams_beside_m.size());
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < depths_m.size(); ++i) {
    const double off = seen.beams_beyond_m[i] + depths_m[i] - depth_m;
    sum += off * off;
  }
  return sum;
}

/// How badly the beams of all sightings fit to a shape, by the variance of a range. A line has a
/// slope, too, that fits to something: one a sighting.
double shape_misfit(std::span<const Sighting> sightings, double radius_m,
                    const LandmarkScene& scene) {
  double chi2 = 0.0;
  for (const Sighting& sighting : sightings) {
    const LandmarkObservation& seen = scene.of(sighting);
    if (seen.beams_beyond_m.size() < 3) continue;
    const double variance = seen.direction.dot(seen.covariance * seen.direction);
    chi2 += radius_m > 0.0 ? circle_misfit(seen, radius_m) / variance
                           : line_misfit(seen) / variance + 1.0;
  }
  return chi2;
}

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
    const Eigen::Vector2d way =
        map_T_node[sighting.node].translation() - map_T_node[sightings.front().node].translation();
    longest = std::max(longest, way.norm());
  }
  return longest;
}

double radius_of(std::span<const Sighting> sightings, double radius_max_m,
                 const LandmarkScene& scene, std::span<const Pose2> map_T_node) {
  const double flat = misfit(sightings, 0.0, scene, map_T_node);
  const double straight = shape_misfit(sightings, 0.0, scene);
  // By the noise that is there, not by what is told; too good to be true for one is no matter.
  const double freedom = std::max(1.0, 2.0 * static_cast<double>(sightings.size()) - 3.0);
  double best = 0.0;
  double radius = 0.0;
  double from = kLandmarkMapping.radius_least_m;
  double to = radius_max_m;
  for (const double step : {kLandmarkMapping.radius_step_m, 0.1 * kLandmarkMapping.radius_step_m}) {
    const int steps = static_cast<int>(std::floor((to - from) / step));
    for (int i = 0; i <= steps; ++i) {
      const double tried = from + step * i;
      const double round = misfit(sightings, tried, scene, map_T_node);
      const double noise = std::max(kLandmarkMapping.least_noise, round / freedom);
      const double gain = (flat - round) / noise + straight - shape_misfit(sightings, tried, scene);
      if (gain <= best) continue;
      best = gain;
      radius = tried;
    }
    from = std::max(radius - step, kLandmarkMapping.radius_least_m);
    to = std::min(radius + step, radius_max_m);
  }
  return best > kLandmarkMapping.round_chi2 ? radius : 0.0;
}

}  // namespace loopstone
