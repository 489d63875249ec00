// Where is the robot among landmarks, and does the filter know when it is wrong? With the right
// map, and with a wrong one.
#include <cmath>
#include <cstdio>

#include "loopstone/localization/landmark_localization.hpp"

using namespace loopstone;

namespace {

/// A quarter of a metre along a circle, and the noise of the wheels.
Pose2 drive_on(const Pose2& map_T_robot, Rng& noise) {
  return map_T_robot * Pose2{0.25 + noise.normal(0.0, 0.03), 0.0, 0.0625 + noise.normal(0.0, 0.02)};
}

std::vector<LandmarkSighting> look_around(const LandmarkModel& world, const Pose2& truth,
                                          Rng& rng) {
  std::vector<LandmarkSighting> sightings;
  for (std::size_t i = 0; i < world.landmarks().size(); ++i) {
    LandmarkSighting seen = world.expected(truth, i);
    seen.range_m += rng.normal(0.0, world.sensor().range_sigma_m);
    seen.bearing_rad += rng.normal(0.0, world.sensor().bearing_sigma_rad);
    if (seen.range_m < world.sensor().max_range_m) sightings.push_back(seen);
  }
  return sightings;
}

FilterStatus drive(const char* title, const LandmarkModel& world, const LandmarkModel& map) {
  Rng rng(1);
  Pose2 truth{4.0, 0.0, 1.6};
  // Nothing is known at first but what is seen: particles all around the first landmarks.
  const auto first_look = look_around(world, truth, rng);
  std::vector<Pose2> particles;
  for (std::size_t i = 0; i < 2000; ++i) {
    particles.push_back(map.sample_pose(first_look[i % first_look.size()], rng));
  }
  LandmarkLocalizer localizer(map, particles, {}, 1);
  LandmarkEstimate estimate;
  std::printf("%s\n", title);
  for (int step = 1; step <= 40; ++step) {
    truth = drive_on(truth, rng);
    localizer.predict(drive_on);
    estimate = localizer.update(look_around(world, truth, rng));
    if (step % 10 != 0) continue;
    std::printf("  step %2d  error %6.3f m  %-12s  %s\n", step,
                (truth.inverse() * estimate.map_T_robot.pose).translation().norm(),
                to_string(estimate.status).data(), reason(estimate.health).c_str());
  }
  return estimate.status;
}

}  // namespace

int main() {
  std::vector<Landmark> landmarks{{1, {9.0, 0.5}},  {2, {7.2, 6.1}},   {3, {2.1, 9.3}},
                                  {4, {-4.4, 8.1}}, {5, {-7.9, -3.7}}, {6, {6.3, -7.4}}};
  const LandmarkModel world(landmarks, LandmarkSensor{});
  for (Landmark& landmark : landmarks) landmark.position.x() *= -1.0;  // somebody mirrored the map
  const FilterStatus right = drive("the right map", world, world);
  const FilterStatus wrong =
      drive("a mirrored map", world, LandmarkModel(landmarks, LandmarkSensor{}));
  return right == FilterStatus::kConverged && wrong == FilterStatus::kInconsistent ? 0 : 1;
}
