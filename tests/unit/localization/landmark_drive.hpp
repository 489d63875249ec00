#pragma once

#include <cmath>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/localization/landmark_localization.hpp"

// A robot that drives round among landmarks.
namespace loopstone::test {

/// Ten landmarks around a hall of 20 m, no two distances alike.
[[nodiscard]] inline std::vector<Landmark> hall_landmarks() {
  return {{1, {9.0, 0.5}},  {2, {7.2, 6.1}},   {3, {2.1, 9.3}},   {4, {-4.4, 8.1}},
          {5, {-8.8, 3.0}}, {6, {-7.9, -3.7}}, {7, {-3.1, -8.6}}, {8, {1.4, -5.9}},
          {9, {6.3, -7.4}}, {10, {0.8, 1.9}}};
}

/// How the simulated robot differs from what the filter is told.
struct DriveFaults {
  double range_scale = 1.0;
  double noise_scale = 1.0;  ///< of the sensor's noise
  double clutter_share = 0.05;
};

struct DriveOptions {
  int steps = 80;
  bool names = true;  ///< sightings say which landmark they are of
  std::size_t particles = 500;
  bool from_anywhere = false;  ///< else from the true pose with 0.5 m and 10 deg
  std::vector<Landmark> believed = hall_landmarks();
  DriveFaults faults{};
  int carried_off_at = -1;  ///< step before which the robot is put elsewhere
};

struct DriveStep {
  Pose2 truth;
  LandmarkEstimate estimate;
  [[nodiscard]] Eigen::Vector3d error() const {
    const Pose2& pose = estimate.map_T_robot.pose;
    return {pose.x - truth.x, pose.y - truth.y, wrap_angle(pose.yaw - truth.yaw)};
  }
  [[nodiscard]] double error_m() const { return error().head<2>().norm(); }
};

[[nodiscard]] inline std::vector<LandmarkSighting> look_around(const LandmarkModel& world,
                                                               const Pose2& truth,
                                                               const DriveFaults& faults,
                                                               bool names, Rng& rng) {
  const LandmarkSensor& sensor = world.sensor();
  std::vector<LandmarkSighting> sightings;
  for (std::size_t i = 0; i < world.landmarks().size(); ++i) {
    LandmarkSighting seen = world.expected(truth, i);
    if (seen.range_m > sensor.max_range_m) continue;
    if (rng.uniform() < faults.clutter_share) {
      seen.range_m = rng.uniform(0.1, sensor.max_range_m);
      seen.bearing_rad = rng.uniform(-kPi, kPi);
    } else {
      seen.range_m = seen.range_m * faults.range_scale +
                     rng.normal(0.0, faults.noise_scale * sensor.range_sigma_m);
      seen.bearing_rad = wrap_angle(seen.bearing_rad +
                                    rng.normal(0.0, faults.noise_scale * sensor.bearing_sigma_rad));
    }
    if (!names) seen.id.reset();
    sightings.push_back(seen);
  }
  return sightings;
}

/// Drives a circle of 4 m, a quarter metre a step; the motion's noise is what the filter is told.
[[nodiscard]] inline std::vector<DriveStep> drive(const DriveOptions& options, std::uint64_t seed) {
  LandmarkSensor sensor;
  sensor.max_range_m = 8.0;
  const LandmarkModel world(hall_landmarks(), sensor);
  Rng rng(seed);
  const Pose2 commanded{0.25, 0.0, 0.25 / 4.0};
  const auto moved = [&](const Pose2& from, Rng& noise) {
    return from * Pose2{commanded.x + noise.normal(0.0, 0.03), noise.normal(0.0, 0.01),
                        commanded.yaw + noise.normal(0.0, 0.02)};
  };
  Pose2 truth{4.0, 0.0, kPi / 2.0};
  std::vector<Pose2> first;
  const auto first_sightings =
      look_around(world, truth, {.clutter_share = 0.0}, options.names, rng);
  const LandmarkModel believed(options.believed, sensor);
  for (std::size_t i = 0; i < options.particles; ++i) {
    if (options.from_anywhere) {
      first.push_back(believed.sample_pose(first_sightings[i % first_sightings.size()], rng));
    } else {
      first.push_back({truth.x + rng.normal(0.0, 0.5), truth.y + rng.normal(0.0, 0.5),
                       wrap_angle(truth.yaw + rng.normal(0.0, radians(10.0)))});
    }
  }
  LandmarkLocalizer localizer(believed, std::move(first), {}, seed + 1);
  std::vector<DriveStep> steps;
  for (int step = 0; step < options.steps; ++step) {
    truth = moved(truth, rng);
    if (step == options.carried_off_at) truth = {-truth.x, -truth.y, wrap_angle(truth.yaw + 2.0)};
    localizer.predict(moved);
    const auto sightings = look_around(world, truth, options.faults, options.names, rng);
    steps.push_back({truth, localizer.update(sightings)});
  }
  return steps;
}

}  // namespace loopstone::test
