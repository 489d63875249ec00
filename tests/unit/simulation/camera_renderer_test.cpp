#include "loopstone/simulation/camera_renderer.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/sensor/camera_geometry.hpp"
#include "loopstone/simulation/simulated_camera.hpp"

namespace loopstone {
namespace {

constexpr double kPatch = 16.0;  ///< [m]

/// Red grows with x and green with y, from 0 to 1 over 16 m, so that a colour says which point of
/// the floor is seen.
std::shared_ptr<const FloorPattern> ramps() {
  constexpr int kTexels = 128;
  std::vector<LinearColour> texels;
  for (int row = 0; row < kTexels; ++row) {
    for (int column = 0; column < kTexels; ++column) {
      texels.emplace_back((static_cast<float>(column) + 0.5F) / kTexels,
                          (static_cast<float>(row) + 0.5F) / kTexels, 0.0F);
    }
  }
  return std::make_shared<const FloorPattern>(
      kTexels, kTexels, Eigen::Vector2d(kPatch / kTexels, kPatch / kTexels), texels);
}

Eigen::Vector2d point_of(const LinearColour& colour) {
  return kPatch * colour.head<2>().cast<double>();
}

/// A world with a floor that tells its coordinates, and what the plan holds.
World world_with(FloorPlan plan) {
  World world;
  world.name = "test";
  world.plan = std::move(plan);
  // Something far away, so that the index has an extent.
  world.plan.boxes.push_back({{300.0, 300.0, 0.0}, 1.0, 1.0, true});
  world.floor = ramps();
  return world;
}

/// A quarter of the Kinect's pixels; both cameras look along the robot's x axis from 0.5 m above
/// its centre.
CameraModel level_camera() {
  CameraModel camera;
  camera.robot_T_camera = Pose3{{0.0, 0.0, 0.5}, Eigen::Quaterniond::Identity()};
  camera.depth = {.focal_x_px = 100.0,
                  .focal_y_px = 100.0,
                  .centre_x_px = 80.0,
                  .centre_y_px = 60.0,
                  .width_px = 161,
                  .height_px = 121};
  camera.colour = camera.depth;
  return camera;
}

struct Scene {
  explicit Scene(FloorPlan plan, const CameraModel& camera)
      : world(world_with(std::move(plan))),
        surfaces(world.plan),
        renderer(world, surfaces, camera) {}
  World world;
  SurfaceIndex surfaces;
  CameraRenderer renderer;
};

std::size_t at(int width, int column, int row) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
         static_cast<std::size_t>(column);
}

TEST(CameraRenderer, AFloorPointHasThePixelAndTheDepthThatGeometrySays) {
  // Half a metre up and 30 deg down: the axis meets the floor after 1 m, 0.866 m ahead. A ray 15
  // deg below it meets the floor at 45 deg, 0.5 m ahead, after 0.7071 m, of which 0.7071 cos 15 deg
  // = 0.6830 m are along the axis.
  CameraModel camera = level_camera();
  camera.robot_T_camera = Pose3::from_roll_pitch_yaw({0.2, 0.1, 0.5}, 0.0, radians(30.0), 0.0);
  camera.camera_T_colour = Pose3{};
  camera.depth.focal_y_px = camera.colour.focal_y_px = 40.0 / std::tan(radians(15.0));
  const Scene scene({}, camera);
  const TrueDepth depth = scene.renderer.depth({5.0, 3.0, 0.0});
  const LightImage light = scene.renderer.light({{5.0, 3.0, 0.0}});
  EXPECT_NEAR(depth.depth.at(80, 60), 1.0, 1e-6);
  EXPECT_NEAR(depth.depth.at(80, 100), 1.0 / 0.683013, 1e-5);
  EXPECT_NEAR(depth.facing[at(161, 80, 60)], 0.5, 1e-6);
  EXPECT_LT((point_of(light.pixels[at(161, 80, 60)]) - Eigen::Vector2d(6.066025, 3.1)).norm(),
            1e-3);
  EXPECT_LT((point_of(light.pixels[at(161, 80, 100)]) - Eigen::Vector2d(5.7, 3.1)).norm(), 1e-3);
  // As a Kinect's number: (1.03 / 1 m - 3.31) / -0.00304 = 750.
  const DepthEncoding encoding;
  EXPECT_NEAR((1.03 * static_cast<double>(depth.depth.at(80, 60)) - encoding.disparity_offset) /
                  encoding.disparity_slope,
              750.0, 1e-3);
}

TEST(CameraRenderer, RightIsRightNearIsLowAndTheRobotsHeadingCounts) {
  CameraModel camera = level_camera();
  const Scene scene({}, camera);
  const LightImage light = scene.renderer.light({{5.0, 3.0, 0.5 * kPi}});  // looks along y
  const auto seen = [&](int column, int row) {
    return point_of(light.pixels[at(161, column, row)]);
  };
  EXPECT_GT(seen(120, 100).x(), 5.3);  // to the right of a robot that looks along y is +x
  EXPECT_LT(seen(40, 100).x(), 4.7);
  EXPECT_GT(seen(80, 90).y(), seen(80, 110).y() + 0.3);
  EXPECT_GT(seen(80, 110).y(), 3.5);
}

TEST(CameraRenderer, RollPitchAndYawTurnInTheirOrder) {
  const double roll = 0.2;
  const double pitch = 0.5;
  const double yaw = 0.3;
  CameraModel camera = level_camera();
  camera.robot_T_camera = Pose3::from_roll_pitch_yaw({0.2, -0.1, 0.4}, roll, pitch, yaw);
  camera.camera_T_colour = Pose3{};
  const Scene scene({}, camera);
  const Pose2 map_T_robot{6.0, 7.0, 1.1};
  const LightImage light = scene.renderer.light({map_T_robot});
  const TrueDepth depth = scene.renderer.depth(map_T_robot);
  for (const auto& [column, row] : {std::pair{80, 60}, {0, 110}, {160, 120}, {30, 70}}) {
    // By hand: forward 1, right (u - cx) / f, down (v - cy) / f; then roll about x, pitch about y,
    // yaw about z.
    Eigen::Vector3d ray(1.0, -(column - 80.0) / 100.0, -(row - 60.0) / 100.0);
    ray = Eigen::Vector3d(ray.x(), std::cos(roll) * ray.y() - std::sin(roll) * ray.z(),
                          std::sin(roll) * ray.y() + std::cos(roll) * ray.z());
    ray = Eigen::Vector3d(std::cos(pitch) * ray.x() + std::sin(pitch) * ray.z(), ray.y(),
                          -std::sin(pitch) * ray.x() + std::cos(pitch) * ray.z());
    ray = Eigen::Vector3d(std::cos(yaw) * ray.x() - std::sin(yaw) * ray.y(),
                          std::sin(yaw) * ray.x() + std::cos(yaw) * ray.y(), ray.z());
    ASSERT_LT(ray.z(), 0.0);
    const double distance = 0.4 / -ray.z();
    const Eigen::Vector2d point =
        map_T_robot * Eigen::Vector2d(0.2 + distance * ray.x(), -0.1 + distance * ray.y());
    EXPECT_LT((point_of(light.pixels[at(161, column, row)]) - point).norm(), 2e-3);
    EXPECT_NEAR(depth.depth.at(column, row), 1.0 / distance, 1e-5);  // rays have 1 along the axis
  }
}

TEST(CameraRenderer, AWallAcrossTheViewHasOneDepth) {
  const CameraModel camera = level_camera();
  // Its face is 2.5 m before the camera.
  const Scene scene({.boxes = {{{3.0, 0.0, 0.5 * kPi}, 8.0, 1.0, true}}}, camera);
  const TrueDepth depth = scene.renderer.depth({0.0, 0.0, 0.0});
  for (int column = 0; column < 161; column += 20) {
    EXPECT_NEAR(depth.depth.at(column, 60), 0.4, 1e-6);
    EXPECT_NEAR(depth.depth.at(column, 75), 0.4, 1e-6);
  }
  EXPECT_NEAR(depth.facing[at(161, 80, 60)], 1.0, 1e-6);
  EXPECT_NEAR(depth.facing[at(161, 160, 60)], std::cos(std::atan(0.8)), 1e-6);
  // The wall stands on the floor: 20 px below the axis is its foot at 2.5 m; below that the floor
  // is nearer.
  EXPECT_NEAR(depth.depth.at(80, 79), 0.4, 1e-6);
  EXPECT_NEAR(depth.depth.at(80, 90), 0.30 / 0.5, 1e-6);
}

TEST(CameraRenderer, TheColourCameraSeesFromWhereThePublishedRegistrationPutsIt) {
  // A thin pole in front of the UCSD robot's camera, in both pictures.
  CameraModel camera;
  camera.robot_T_camera = Pose3{{0.0, 0.0, 0.4}, Eigen::Quaterniond::Identity()};
  for (const double side : {-0.3, 0.0, 0.25}) {
    const Scene scene({.circles = {{{1.2, side}, 0.02}}}, camera);
    const TrueDepth depth = scene.renderer.depth({0.0, 0.0, 0.0});
    const LightImage light = scene.renderer.light({{0.0, 0.0, 0.0}});
    const int row = 300;
    double sum = 0.0;
    double count = 0.0;
    double inverse = 0.0;
    const float background = depth.depth.at(5, row);
    for (int column = 0; column < 640; ++column) {
      if (depth.depth.at(column, row) < background + 0.1F) continue;
      sum += column;
      count += 1.0;
      inverse = std::max(inverse, static_cast<double>(depth.depth.at(column, row)));
    }
    ASSERT_GT(count, 5.0);
    const double dd = 1.03 * inverse;
    const double predicted_column = (526.37 * sum / count + 19276.0 - 7877.07 * dd) / 585.051;
    const auto predicted_row = static_cast<int>(std::lround((526.37 * row + 16662.0) / 585.051));
    double colour_sum = 0.0;
    double colour_count = 0.0;
    for (int column = 0; column < 640; ++column) {
      const LinearColour& pixel = light.pixels[at(640, column, predicted_row)];
      if (pixel.z() < 0.01F) continue;  // the floor has no blue
      colour_sum += column;
      colour_count += 1.0;
    }
    ASSERT_GT(colour_count, 5.0);
    EXPECT_NEAR(colour_sum / colour_count, predicted_column, 0.6) << side;
  }
}

TEST(CameraRenderer, LensDistortionBendsBothPictures) {
  CameraModel camera = level_camera();
  camera.robot_T_camera = Pose3::from_roll_pitch_yaw({0.0, 0.0, 0.5}, 0.0, 0.6, 0.0);
  camera.camera_T_colour = Pose3{};
  camera.colour.k1 = camera.depth.k1 = -0.15;
  camera.colour.p1 = camera.depth.p1 = 0.01;
  const Scene scene({}, camera);
  const LightImage light = scene.renderer.light({{4.0, 8.0, 0.0}});
  const TrueDepth depth = scene.renderer.depth({4.0, 8.0, 0.0});
  const Pose3 robot_T_optical = robot_T_depth_optical(camera);
  for (const auto& [column, row] : {std::pair{10, 110}, {80, 60}, {150, 70}}) {
    const auto inverse = static_cast<double>(depth.depth.at(column, row));
    const Eigen::Vector2d point =
        point_of(light.pixels[at(161, column, row)]) - Eigen::Vector2d(4.0, 8.0);
    const Eigen::Vector3d p_optical =
        robot_T_optical.inverse() * Eigen::Vector3d(point.x(), point.y(), 0.0);
    EXPECT_LT((project(camera.depth, p_optical) - Eigen::Vector2d(column, row)).norm(), 0.3);
    EXPECT_NEAR(p_optical.z(), 1.0 / inverse, 2e-3);
  }
}

TEST(CameraRenderer, FarFloorHasTheMeanColourOfItsPattern) {
  // A chequerboard of 4 cm, seen from 6 m on where it can't be told apart any more.
  World world = world_with({});
  std::vector<LinearColour> texels;
  for (int i = 0; i < 64 * 64; ++i) {
    texels.push_back(((i % 64) / 4 + (i / 64) / 4) % 2 == 0 ? LinearColour(0.9F, 0.5F, 0.1F)
                                                            : LinearColour(0.1F, 0.1F, 0.3F));
  }
  world.floor = std::make_shared<const FloorPattern>(64, 64, Eigen::Vector2d(0.01, 0.01), texels);
  const SurfaceIndex surfaces(world.plan);
  const CameraRenderer renderer(world, surfaces, level_camera());
  const LightImage light = renderer.light({{0.3, 0.1, 0.4}});
  for (int row = 63; row < 68; ++row) {
    for (int column = 0; column < 161; ++column) {
      EXPECT_LT((light.pixels[at(161, column, row)] - LinearColour(0.5F, 0.3F, 0.2F)).norm(),
                0.03F);
    }
  }
  // Near by, squares are seen as they are.
  float darkest = 1.0F;
  for (int column = 0; column < 161; ++column) {
    darkest = std::min(darkest, light.pixels[at(161, column, 119)].x());
  }
  EXPECT_LT(darkest, 0.15F);
}

TEST(CameraRenderer, MotionSmearsAlongItselfOnly) {
  World world = world_with({});
  std::vector<LinearColour> texels;  // stripes along y, 8 cm each
  for (int i = 0; i < 64 * 64; ++i) {
    texels.push_back(LinearColour::Constant((i % 64) / 8 % 2 == 0 ? 1.0F : 0.0F));
  }
  world.floor = std::make_shared<const FloorPattern>(64, 64, Eigen::Vector2d(0.01, 0.01), texels);
  const SurfaceIndex surfaces(world.plan);
  const CameraModel camera = level_camera();
  const CameraRenderer renderer(world, surfaces, camera);
  const auto contrast = [&](double yaw, double travelled_m, double turned_rad) {
    const LightImage light = renderer.light({{0.0, 0.0, yaw}, travelled_m, turned_rad});
    double sum = 0.0;
    double squares = 0.0;
    double count = 0.0;
    for (int row = 100; row < 121; ++row) {
      for (int column = 0; column < 161; ++column) {
        const auto value = static_cast<double>(light.pixels[at(161, column, row)].x());
        sum += value;
        squares += value * value;
        count += 1.0;
      }
    }
    return std::sqrt(squares / count - sum * sum / (count * count));
  };
  EXPECT_GT(contrast(0.0, 0.0, 0.0), 0.4);
  EXPECT_LT(contrast(0.0, 0.16, 0.0), 0.2);        // across the stripes
  EXPECT_GT(contrast(0.5 * kPi, 0.16, 0.0), 0.4);  // along them
  EXPECT_GT(contrast(0.0, 0.0, 0.1), 0.35);  // a turn moves what is ahead sideways: along them
  EXPECT_LT(contrast(0.5 * kPi, 0.0, 0.16), 0.25);  // across
}

TEST(CameraRenderer, EveryDepthIsThatOfTheRayThroughThePixelsCentre) {
  const World world = make_world("office", 3);
  World plain = world_with(world.plan);
  const SurfaceIndex surfaces(plain.plan);
  CameraModel camera = level_camera();
  camera.robot_T_camera = Pose3::from_roll_pitch_yaw({0.2, 0.1, 0.4}, 0.05, 0.2, 0.1);
  const CameraRenderer renderer(plain, surfaces, camera);
  const Pose3 robot_T_optical = robot_T_depth_optical(camera);
  Rng rng(6);
  int wrong = 0;
  int walls = 0;
  int all = 0;
  for (std::size_t place = 0; place < 6; ++place) {
    const Eigen::Vector2d& at_place = world.places[place];
    const Pose2 map_T_robot{at_place.x(), at_place.y(), rng.uniform(-3.0, 3.0)};
    const std::vector<Circle> legs{{map_T_robot * Eigen::Vector2d(1.2, 0.2), 0.06}};
    const TrueDepth depth = renderer.depth(map_T_robot, legs);
    const Pose3 map_T_optical = Pose3::from_pose2(map_T_robot) * robot_T_optical;
    for (int row = 0; row < 121; row += 5) {
      for (int column = 0; column < 161; ++column) {
        const Eigen::Vector3d ray =
            map_T_optical.rotation * ray_through(camera.depth, {column, row});
        const double length = ray.head<2>().norm();
        const Eigen::Vector2d direction = ray.head<2>() / length;
        const Eigen::Vector2d origin = map_T_optical.translation.head<2>();
        const double wall = std::min(surfaces.cast(origin, direction, 60.0),
                                     range_to(legs.front(), origin, direction));
        const double rise =
            ray.z() < 0.0 ? -map_T_optical.translation.z() : 2.5 - map_T_optical.translation.z();
        const double flat = rise / ray.z() * length;
        const double expected = length / std::min(wall, flat);  // 1 / depth along the axis
        ++all;
        if (wall < flat) ++walls;
        if (std::abs(static_cast<double>(depth.depth.at(column, row)) - expected) > 1e-5) ++wrong;
      }
    }
  }
  EXPECT_GT(walls, all / 10);
  // Rays that graze a corner fall to either side by rounding.
  EXPECT_LE(wrong, all / 2000) << "of " << all;
}

TEST(CameraRenderer, TrueCameraDiffersByTheErrors) {
  SimulatedCamera options;
  options.pitch_error_rad = 0.02;
  options.roll_error_rad = -0.01;
  options.height_error_m = 0.03;
  const CameraModel model;
  const CameraModel truth = true_camera(model, options);
  EXPECT_TRUE(truth.robot_T_camera.rotation.isApprox(
      Pose3::from_roll_pitch_yaw({0.0, 0.0, 0.0}, -0.01, 0.38, 0.021).rotation, 1e-12));
  EXPECT_NEAR(truth.robot_T_camera.translation.z(), 0.39, 1e-12);
  // Positive pitch looks down, positive roll lowers the right side.
  const Eigen::Vector3d ahead(1.0, 0.0, 0.0);
  EXPECT_LT((truth.robot_T_camera.rotation * ahead).z(),
            (model.robot_T_camera.rotation * ahead).z());
}

TEST(CameraRenderer, RefusesACameraInTheFloor) {
  const World world = world_with({});
  const SurfaceIndex surfaces(world.plan);
  CameraModel camera = level_camera();
  camera.robot_T_camera.translation.z() = 0.0;
  EXPECT_THROW(CameraRenderer(world, surfaces, camera), UsageError);
}

}  // namespace
}  // namespace loopstone
