#include "mapping/cloud_gatherer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "loopstone/base/linear_light.hpp"
#include "loopstone/grid/grid_frame.hpp"
#include "loopstone/sensor/camera_geometry.hpp"
#include "support/rendered_floor.hpp"

namespace loopstone {
namespace {

constexpr double kCube_m = 0.05;
constexpr double kExact_per_m = 1e-9;  // no noise: nothing is too far

/// A red box, higher than the camera sees; its sides are not those of cubes.
const test::StandingBox kBox{{1.013, -0.36, 0.0}, {1.213, 0.36, 1.0}, {0.8, 0.05, 0.05}};

/// Colours change slowly.
Eigen::Vector3d slow_floor(double x, double y) {
  return {0.1, 0.4 + 0.1 * std::sin(2.0 * x), 0.5 + 0.1 * std::cos(2.0 * y)};
}

const std::vector<Pose2> kPoses{
    {0.0, 0.0, 0.0}, {0.1, 0.2, -0.1}, {-0.2, -0.1, 0.15}, {0.2, -0.2, 0.2}};

FramePose standing_at(const Pose2& pose) { return {pose, pose}; }

/// Along the axes of the box: 0 inside.
double distance_to_surface_m(const Eigen::Vector3d& point) {
  const Eigen::Array3d outside =
      (kBox.low - point).array().max((point - kBox.high).array()).max(0.0);
  const Eigen::Array3d inside = (point - kBox.low).array().min((kBox.high - point).array());
  const double to_box = std::max(outside.matrix().norm(), inside.minCoeff());
  return std::min(std::abs(point.z()), to_box);
}

/// Where the cubes may hold more than one surface.
bool near_corner(const Eigen::Vector3d& point, double reach_m) {
  const Eigen::Array3d outside =
      (kBox.low - point).array().max((point - kBox.high).array()).max(0.0);
  const bool at_foot = point.z() < reach_m && outside.head<2>().matrix().norm() < reach_m;
  const Eigen::Array2d to_side =
      (point - kBox.low).array().abs().min((kBox.high - point).array().abs()).head<2>();
  return at_foot || (outside.maxCoeff() < reach_m && to_side.maxCoeff() < reach_m);
}

std::vector<ColouredPoint> gather(const test::FloorScene& scene, const std::vector<Pose2>& poses,
                                  double noise_per_m = kExact_per_m, double cube_m = kCube_m,
                                  int times = 1) {
  const CameraModel camera = test::small_camera();
  CloudGatherer gatherer(camera, noise_per_m, cube_m);
  for (const Pose2& pose : poses) {
    const RgbdImages images = test::render(scene, camera, pose, pose);
    for (int i = 0; i < times; ++i) gatherer.add(images, standing_at(pose));
  }
  return gatherer.points();
}

TEST(CloudGatherer, PointsLieOnWhatWasSeenInItsColour) {
  const test::FloorScene scene{slow_floor, {kBox}};
  std::size_t on_floor = 0;
  std::size_t on_box = 0;
  std::size_t wrong = 0;
  for (const ColouredPoint& point : gather(scene, kPoses)) {
    const Eigen::Vector3d at = point.position_m.cast<double>();
    ASSERT_LT(distance_to_surface_m(at), kCube_m);
    if (near_corner(at, 2.0 * kCube_m)) continue;
    ASSERT_LT(distance_to_surface_m(at), 1e-4) << at.transpose();
    const bool is_floor = std::abs(at.z()) < 1e-3;
    const Eigen::Vector3d light = is_floor ? slow_floor(at.x(), at.y()) : kBox.light;
    ++(is_floor ? on_floor : on_box);
    double off = 0.0;
    for (int c = 0; c < 3; ++c) {
      off = std::max(
          off, std::abs(point.rgb[static_cast<std::size_t>(c)] - 255.0 * srgb_of_linear(light[c])));
    }
    if (off > 4.0) ++wrong;
  }
  EXPECT_GT(on_floor, 300U);
  EXPECT_GT(on_box, 40U);
  EXPECT_EQ(wrong, 0U);
}

TEST(CloudGatherer, ACubeIsTheMeanOfItsMeasurements) {
  // Every measurement has its own cube of a millimetre, and is seen three times.
  const test::FloorScene scene{slow_floor};
  const Pose2 pose{0.3, 0.2, 0.7};
  const CameraModel camera = test::small_camera();
  const std::vector<ColouredPoint> points = gather(scene, {pose}, kExact_per_m, 0.001, 3);
  EXPECT_GT(points.size(), 2000U);
  const Pose3 colour_T_map = (Pose3::from_pose2(pose) * robot_T_colour_optical(camera)).inverse();
  const Pose3 depth_T_map = (Pose3::from_pose2(pose) * robot_T_depth_optical(camera)).inverse();
  const RgbdImages images = test::render(scene, camera, pose, pose);
  for (const ColouredPoint& point : points) {
    const Eigen::Vector3d at = point.position_m.cast<double>();
    const Eigen::Vector2d pixel = project(camera.depth, Eigen::Vector3d(depth_T_map * at));
    EXPECT_LT((pixel - pixel.array().round().matrix()).norm(), 0.01) << "a pixel's middle";
    const Eigen::Vector2d seen = project(camera.colour, Eigen::Vector3d(colour_T_map * at));
    const auto u = static_cast<int>(std::lround(seen.x()));
    const auto v = static_cast<int>(std::lround(seen.y()));
    if (std::abs(seen.x() - u) > 0.49 || std::abs(seen.y() - v) > 0.49) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(point.rgb[c], images.colour.at(u, v)[c], 1);
    }
  }
}

TEST(CloudGatherer, CubesMeasuredFewerThanThreeTimesAreLeftOut) {
  const test::FloorScene scene{slow_floor};
  EXPECT_EQ(gather(scene, {Pose2{}}, kExact_per_m, 0.001, 1).size(), 0U);
  EXPECT_EQ(gather(scene, {Pose2{}}, kExact_per_m, 0.001, 2).size(), 0U);
  EXPECT_GT(gather(scene, {Pose2{}}, kExact_per_m, 0.001, 3).size(), 2000U);
}

TEST(CloudGatherer, OrderIsThatOfTheCubesWhateverCameFirst) {
  const test::FloorScene scene{slow_floor, {kBox}};
  const std::vector<ColouredPoint> one = gather(scene, kPoses);
  const std::vector<ColouredPoint> other =
      gather(scene, std::vector<Pose2>(kPoses.rbegin(), kPoses.rend()));
  const auto cube_of = [](const ColouredPoint& point) {
    std::array<int, 3> cube{};
    for (int axis = 0; axis < 3; ++axis) {
      // Means at a cube's very side round to either: look a little inside.
      cube[static_cast<std::size_t>(axis)] =
          floor_to_int((static_cast<double>(point.position_m[axis]) + 1e-6) / kCube_m);
    }
    return cube;
  };
  ASSERT_EQ(one.size(), other.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_LT((one[i].position_m - other[i].position_m).norm(), 1e-4F) << i;
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(one[i].rgb[c], other[i].rgb[c], 16);
  }
  for (std::size_t i = 1; i < one.size(); ++i) {
    // The floor is the side of two cubes, so of z only the order within a column of cubes off the
    // floor is told.
    const auto before = cube_of(one[i - 1]);
    const auto here = cube_of(one[i]);
    ASSERT_LE((std::array<int, 2>{before[0], before[1]}), (std::array<int, 2>{here[0], here[1]}));
  }
}

TEST(CloudGatherer, WhatIsTooFarForItsNoiseIsLeftOut) {
  const test::FloorScene scene{slow_floor};
  const Pose3 depth_T_map = robot_T_depth_optical(test::small_camera()).inverse();
  const auto farthest_m = [&](double noise_per_m) {
    double farthest = 0.0;
    for (const ColouredPoint& point : gather(scene, {Pose2{}}, noise_per_m, kCube_m, 3)) {
      farthest =
          std::max(farthest, (depth_T_map * Eigen::Vector3d(point.position_m.cast<double>())).z());
    }
    return farthest;
  };
  EXPECT_GT(farthest_m(kExact_per_m), 2.0);
  // Noise of depth is depth^2 * noise: a cube of 5 cm at sqrt(0.05 / 0.02) m.
  EXPECT_LT(farthest_m(0.02), std::sqrt(kCube_m / 0.02) + kCube_m);
  EXPECT_GT(farthest_m(0.02), std::sqrt(kCube_m / 0.02) - 0.2);
}

TEST(CloudGatherer, PixelsBetweenThingsMakeNoPoints) {
  // At the sides of things cameras measure depths between near and far: points that hang in the
  // air.
  const test::FloorScene scene{slow_floor, {kBox}};
  const CameraModel camera = test::small_camera();
  CloudGatherer gatherer(camera, kExact_per_m, kCube_m);
  int smeared = 0;
  for (const Pose2& pose : kPoses) {
    RgbdImages images = test::render(scene, camera, pose, pose);
    for (int row = 0; row < images.depth.height; ++row) {
      for (int column = 0; column + 1 < images.depth.width; ++column) {
        const float near = images.depth.at(column, row);
        const float far = images.depth.at(column + 1, row);
        if (std::abs(near - far) < 0.2F * std::max(near, far) || near * far == 0.0F) continue;
        images.depth.per_m[static_cast<std::size_t>(row * images.depth.width + column)] =
            0.5F * (near + far);
        ++smeared;
        ++column;
      }
    }
    for (int i = 0; i < 3; ++i) gatherer.add(images, standing_at(pose));
  }
  EXPECT_GT(smeared, 100);
  const std::vector<ColouredPoint> points = gatherer.points();
  EXPECT_GT(points.size(), 1000U);
  for (const ColouredPoint& point : points) {
    const Eigen::Vector3d at = point.position_m.cast<double>();
    ASSERT_LT(distance_to_surface_m(at), near_corner(at, 2.0 * kCube_m) ? kCube_m : 1e-4);
  }
}

TEST(CloudGatherer, NoFramesNoPoints) {
  const CloudGatherer gatherer(test::small_camera(), kExact_per_m, kCube_m);
  EXPECT_TRUE(gatherer.points().empty());
}

}  // namespace
}  // namespace loopstone
