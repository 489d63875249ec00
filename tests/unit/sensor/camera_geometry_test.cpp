#include "loopstone/sensor/camera_geometry.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

LensModel bent_lens(Rng& rng) {
  LensModel lens;
  lens.focal_x_px = rng.uniform(450.0, 700.0);
  lens.focal_y_px = rng.uniform(450.0, 700.0);
  lens.k1 = rng.uniform(-0.25, 0.25);
  lens.k2 = rng.uniform(-0.05, 0.1);
  lens.p1 = rng.uniform(-0.005, 0.005);
  lens.p2 = rng.uniform(-0.005, 0.005);
  lens.k3 = rng.uniform(-0.02, 0.02);
  return lens;
}

Vector2d any_pixel(Rng& rng, const LensModel& lens) {
  return {rng.uniform(0.0, lens.width_px - 1.0), rng.uniform(0.0, lens.height_px - 1.0)};
}

TEST(Lens, ProjectAndRayThroughAreInverse) {
  Rng rng(1);
  for (int i = 0; i < 2000; ++i) {
    const LensModel lens = i % 2 == 0 ? LensModel{} : bent_lens(rng);
    const Vector2d pixel = any_pixel(rng, lens);
    const Vector3d ray = ray_through(lens, pixel);
    EXPECT_EQ(ray.z(), 1.0);
    EXPECT_LT((project(lens, ray * rng.uniform(0.1, 20.0)) - pixel).norm(), 1e-8);
    const Vector3d again = ray_through(lens, project(lens, ray));
    EXPECT_LT((again - ray).norm(), 1e-10);
  }
}

TEST(Lens, DistortionIsThatOfOpenCv) {
  LensModel lens;
  lens.focal_x_px = 500.0;
  lens.focal_y_px = 400.0;
  lens.centre_x_px = 320.0;
  lens.centre_y_px = 240.0;
  EXPECT_FALSE(is_distorted(lens));
  EXPECT_EQ(project(lens, {0.2, -0.1, 0.5}), Vector2d(520.0, 160.0));
  lens.k1 = 0.1;
  lens.k2 = 0.2;
  lens.p1 = 0.01;
  lens.p2 = 0.02;
  lens.k3 = 0.3;
  EXPECT_TRUE(is_distorted(lens));
  // By hand: x = 0.4, y = -0.2, r2 = 0.2; radial = 1 + 0.02 + 0.008 + 0.0024 = 1.0304;
  // x' = 0.41216 + 2 * 0.01 * (-0.08) + 0.02 * (0.2 + 0.32) = 0.42096;
  // y' = -0.20608 + 0.01 * (0.2 + 0.08) + 2 * 0.02 * (-0.08) = -0.20648.
  const Vector2d pixel = project(lens, {0.2, -0.1, 0.5});
  EXPECT_NEAR(pixel.x(), 500.0 * 0.42096 + 320.0, 1e-9);
  EXPECT_NEAR(pixel.y(), 400.0 * -0.20648 + 240.0, 1e-9);
}

TEST(OpticalFrame, AxesAreForwardRightDown) {
  const Eigen::Matrix3d r = body_R_optical();
  EXPECT_EQ(r * Vector3d::UnitZ(), Vector3d::UnitX());   // forward
  EXPECT_EQ(r * Vector3d::UnitX(), -Vector3d::UnitY());  // right
  EXPECT_EQ(r * Vector3d::UnitY(), -Vector3d::UnitZ());  // down
  EXPECT_EQ(r.determinant(), 1.0);
}

Vector2d pixel_of(const CameraModel& camera, const Vector3d& p_robot) {
  return project(camera.depth, robot_T_depth_optical(camera).inverse() * p_robot);
}

TEST(OpticalFrame, LeftIsASmallerColumnAndNearerFloorALargerRow) {
  const CameraModel camera;
  const Vector2d ahead = pixel_of(camera, {2.0, 0.0, 0.0});
  const Vector2d left = pixel_of(camera, {2.0, 0.5, 0.0});
  const Vector2d nearer = pixel_of(camera, {1.0, 0.0, 0.0});
  const Vector2d higher = pixel_of(camera, {2.0, 0.0, 0.3});
  EXPECT_LT(left.x(), ahead.x() - 50.0);
  EXPECT_GT(nearer.y(), ahead.y() + 50.0);
  EXPECT_LT(higher.y(), ahead.y() - 50.0);
}

TEST(OpticalFrame, PitchLooksDownAndYawLooksLeft) {
  CameraModel camera;
  camera.robot_T_camera = Pose3::from_roll_pitch_yaw({0.0, 0.0, 0.5}, 0.0, 0.36, 0.0);
  // Without yaw the axis meets the floor straight ahead, at height / tan(pitch).
  const Vector2d centre(camera.depth.centre_x_px, camera.depth.centre_y_px);
  EXPECT_LT((pixel_of(camera, {0.5 / std::tan(0.36), 0.0, 0.0}) - centre).norm(), 1e-9);
  camera.robot_T_camera = Pose3::from_roll_pitch_yaw({0.0, 0.0, 0.5}, 0.0, 0.0, 0.1);
  EXPECT_LT((pixel_of(camera, {std::cos(0.1), std::sin(0.1), 0.5}) - centre).norm(), 1e-9);
  // Roll turns about the axis of sight: the camera's left goes up.
  camera.robot_T_camera = Pose3::from_roll_pitch_yaw({0.0, 0.0, 0.5}, 0.1, 0.0, 0.0);
  const Vector2d left = pixel_of(camera, {1.0, std::cos(0.1) * 0.2, 0.5 + std::sin(0.1) * 0.2});
  EXPECT_NEAR(left.y(), centre.y(), 1e-9);
  EXPECT_NEAR(left.x(), centre.x() - 0.2 * camera.depth.focal_x_px, 1e-9);
}

TEST(OpticalFrame, RotationsFollowYawThenPitchThenRoll) {
  // R = Rz(yaw) Ry(pitch) Rx(roll). Quarter turns by hand: roll sends left (y) up (z); yaw leaves
  // up as it is. In the other order left would go backwards.
  const Pose3 yaw_roll = Pose3::from_roll_pitch_yaw(Vector3d::Zero(), kPi / 2, 0.0, kPi / 2);
  EXPECT_LT((yaw_roll * Vector3d::UnitY() - Vector3d::UnitZ()).norm(), 1e-12);
  // Pitch sends forward (x) down; yaw leaves it there. In the other order it would end on the left.
  const Pose3 yaw_pitch = Pose3::from_roll_pitch_yaw(Vector3d::Zero(), 0.0, kPi / 2, kPi / 2);
  EXPECT_LT((yaw_pitch * Vector3d::UnitX() + Vector3d::UnitZ()).norm(), 1e-12);
  // Roll sends left up, pitch sends up forward. In the other order left would end up.
  const Pose3 pitch_roll = Pose3::from_roll_pitch_yaw(Vector3d::Zero(), kPi / 2, kPi / 2, 0.0);
  EXPECT_LT((pitch_roll * Vector3d::UnitY() - Vector3d::UnitX()).norm(), 1e-12);
}

/// The Kinect's published registration (it comes with the UCSD data), which was fitted by others,
/// against our geometry.
TEST(Registration, AgreesWithThePublishedFormulas) {
  const CameraModel camera;
  const Pose3 colour_T_depth =
      robot_T_colour_optical(camera).inverse() * robot_T_depth_optical(camera);
  for (int disparity = 250; disparity <= 1050; disparity += 50) {
    const double dd = -0.00304 * disparity + 3.31;
    const double depth_m = 1.03 / dd;
    for (int u = 0; u < 640; u += 71) {
      for (int v = 0; v < 480; v += 53) {
        const Vector3d p_depth =
            ray_through(camera.depth, {static_cast<double>(u), static_cast<double>(v)}) * depth_m;
        const Vector2d seen = project(colour_lens(camera), colour_T_depth * p_depth);
        EXPECT_NEAR(seen.x(), (526.37 * u + 19276.0 - 7877.07 * dd) / 585.051, 0.02);
        EXPECT_NEAR(seen.y(), (526.37 * v + 16662.0) / 585.051, 0.02);
      }
    }
  }
}

TEST(Registration, TheColourCameraSitsToTheRight) {
  const CameraModel camera;
  // A near point moves to the left in the camera that sits to its right: the disparity term lowers
  // the column.
  const Pose3 colour_T_depth =
      robot_T_colour_optical(camera).inverse() * robot_T_depth_optical(camera);
  const Vector2d near = project(camera.colour, colour_T_depth * Vector3d(0.0, 0.0, 0.5));
  const Vector2d far = project(camera.colour, colour_T_depth * Vector3d(0.0, 0.0, 5.0));
  EXPECT_LT(near.x(), far.x() - 20.0);
  EXPECT_NEAR(near.y(), far.y(), 1e-9);
}

TEST(Registration, RegisteredColourHasTheDepthCamerasPixels) {
  CameraModel camera;
  camera.colour_is_registered = true;
  const Pose3 depth = robot_T_depth_optical(camera);
  const Pose3 colour = robot_T_colour_optical(camera);
  EXPECT_EQ(colour.translation, depth.translation);
  EXPECT_EQ(colour.rotation.coeffs(), depth.rotation.coeffs());
  EXPECT_EQ(&colour_lens(camera), &camera.depth);
  camera.colour_is_registered = false;
  EXPECT_EQ(&colour_lens(camera), &camera.colour);
}

TEST(InverseDepthTable, DisparitiesFollowTheFormula) {
  const std::vector<float> table = inverse_depth_table(DepthEncoding{});
  ASSERT_EQ(table.size(), 65536u);
  EXPECT_EQ(table[0], 0.0F);
  EXPECT_NEAR(table[400], 2.094 / 1.03, 1e-6);  // 0.4919 m
  EXPECT_NEAR(table[700], 1.182 / 1.03, 1e-6);  // 0.8714 m
  EXPECT_NEAR(table[1000], 0.27 / 1.03, 1e-6);  // 3.8148 m
  // 0.4 m lies between 241 and 242, 10 m between 1054 and 1055.
  EXPECT_EQ(table[241], 0.0F);
  EXPECT_GT(table[242], 0.0F);
  EXPECT_GT(table[1054], 0.0F);
  EXPECT_EQ(table[1055], 0.0F);
  EXPECT_EQ(table[65535], 0.0F);
  for (std::size_t number = 243; number <= 1054; ++number) {
    EXPECT_LT(table[number], table[number - 1]);
  }
}

TEST(InverseDepthTable, DepthIsCountedInUnits) {
  DepthEncoding encoding;
  encoding.kind = DepthKind::kDepth;
  const std::vector<float> table = inverse_depth_table(encoding);
  EXPECT_EQ(table[0], 0.0F);
  EXPECT_EQ(table[399], 0.0F);
  EXPECT_NEAR(table[400], 2.5, 1e-6);
  EXPECT_EQ(table[1000], 1.0F);
  EXPECT_NEAR(table[10000], 0.1, 1e-7);
  EXPECT_EQ(table[10001], 0.0F);
}

}  // namespace
}  // namespace loopstone
