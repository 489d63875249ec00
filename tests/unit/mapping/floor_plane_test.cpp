#include "loopstone/mapping/floor_plane.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/roll_pitch_yaw.hpp"
#include "loopstone/sensor/camera_geometry.hpp"
#include "support/rendered_floor.hpp"

namespace loopstone {
namespace {

CameraModel mounted(CameraModel camera, double roll, double pitch, double yaw, double height_m) {
  const Eigen::Vector3d at = camera.robot_T_camera.translation;
  camera.robot_T_camera = Pose3::from_roll_pitch_yaw({at.x(), at.y(), height_m}, roll, pitch, yaw);
  return camera;
}

test::FloorScene room() {
  return {test::wavy_floor,
          {{{1.6, -2.0, 0.0}, {1.8, 2.0, 2.5}}, {{0.8, 0.2, 0.0}, {1.0, 0.5, 0.4}}}};
}

TEST(FloorPlane, TellsTheDepthOfAFloorPoint) {
  const CameraModel camera = mounted({}, 0.05, 0.4, -0.3, 0.5);
  const FloorPlane plane = floor_plane_of(camera.robot_T_camera);
  EXPECT_NEAR(plane.height_m(), 0.5, 1e-12);
  const Pose3 optical_T_robot = robot_T_depth_optical(camera).inverse();
  for (const Eigen::Vector3d& point :
       {Eigen::Vector3d(1.0, 0.0, 0.0), Eigen::Vector3d(2.0, -0.7, 0.0)}) {
    const Eigen::Vector3d seen = optical_T_robot * point;
    EXPECT_NEAR(plane.slope.dot(seen / seen.z()), 1.0 / seen.z(), 1e-12);
  }
}

TEST(FloorPlane, MountComesBackFromItsPlane) {
  Rng rng(5);
  for (int i = 0; i < 200; ++i) {
    const double roll = rng.uniform(-0.4, 0.4);
    const double pitch = rng.uniform(-0.2, 1.2);
    const double yaw = rng.uniform(-3.0, 3.0);
    const CameraModel camera = mounted({}, roll, pitch, yaw, rng.uniform(0.1, 2.0));
    const Pose3 back = mount_seeing(floor_plane_of(camera.robot_T_camera), camera.robot_T_camera);
    const Eigen::Vector3d angles = to_roll_pitch_yaw(back);
    EXPECT_NEAR(angles.x(), roll, 1e-9);
    EXPECT_NEAR(angles.y(), pitch, 1e-9);
    EXPECT_NEAR(angles.z(), yaw, 1e-9);
    EXPECT_NEAR(back.translation.z(), camera.robot_T_camera.translation.z(), 1e-9);
  }
}

TEST(FloorPlaneEstimator, FindsTheTrueMountBesideAWallAndABox) {
  const CameraModel given = test::small_camera();
  const CameraModel truth = mounted(given, radians(-0.6), 0.36 + radians(1.0), 0.021, 0.36 + 0.012);
  FloorPlaneEstimator floor(given);
  for (int i = 0; i < 8; ++i) {
    const Pose2 pose{-0.2 * i, 0.05 * i, 0.1 * (i - 4)};
    floor.add(test::render(room(), truth, pose, pose, 1, true).depth);
  }
  const FloorEstimate found = floor.estimate();
  ASSERT_EQ(found.status, FloorStatus::kEstimated);
  EXPECT_EQ(found.frames, 8);
  EXPECT_NEAR(degrees(found.pitch_error_rad), 1.0, 0.05);
  EXPECT_NEAR(degrees(found.roll_error_rad), -0.6, 0.05);
  EXPECT_NEAR(found.height_error_m, 0.012, 0.001);
  EXPECT_GT(found.noise_per_m, 0.0002);  // whole steps of 0.003 / m
  EXPECT_LT(found.noise_per_m, 0.003);
  EXPECT_LT(degrees(found.pitch_scatter_rad), 0.1);
}

TEST(FloorPlaneEstimator, NoiseAveragesOut) {
  const CameraModel given = test::small_camera();
  const CameraModel truth = mounted(given, 0.0, 0.36 - radians(0.8), 0.021, 0.36);
  Rng rng(7);
  FloorPlaneEstimator floor(given);
  for (int i = 0; i < 10; ++i) {
    const Pose2 pose{0.1 * i, 0.0, 0.0};
    InverseDepthImage depth = test::render({test::wavy_floor}, truth, pose, pose, 1).depth;
    for (float& per_m : depth.per_m) {
      if (per_m > 0.0F) per_m += static_cast<float>(0.006 * rng.normal(0.0, 1.0));
    }
    floor.add(depth);
  }
  const FloorEstimate found = floor.estimate();
  ASSERT_EQ(found.status, FloorStatus::kEstimated);
  EXPECT_NEAR(degrees(found.pitch_error_rad), -0.8, 0.1);
  EXPECT_NEAR(found.noise_per_m, 0.006, 0.0015);
}

TEST(FloorPlaneEstimator, KeepsTheGivenMountWhereNoFloorIsSeen) {
  const CameraModel camera = test::small_camera();
  FloorPlaneEstimator floor(camera);
  EXPECT_EQ(floor.estimate().status, FloorStatus::kNotSeen);
  InverseDepthImage wall{camera.depth.width_px, camera.depth.height_px, {}};
  wall.per_m.assign(static_cast<std::size_t>(wall.width) * static_cast<std::size_t>(wall.height),
                    1.0F / 0.45F);
  floor.add(wall);
  const FloorEstimate found = floor.estimate();
  EXPECT_EQ(found.status, FloorStatus::kNotSeen);
  EXPECT_EQ(found.robot_T_camera.translation, camera.robot_T_camera.translation);
  EXPECT_EQ(found.pitch_error_rad, 0.0);
}

}  // namespace
}  // namespace loopstone
