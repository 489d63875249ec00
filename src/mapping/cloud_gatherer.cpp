#include "mapping/cloud_gatherer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "geometry/single_product.hpp"
#include "loopstone/base/linear_light.hpp"
#include "loopstone/grid/grid_frame.hpp"
#include "loopstone/sensor/camera_geometry.hpp"

namespace loopstone {
namespace {

constexpr int kEvery = 2;            ///< pixels looked at, in both directions
constexpr int kNeighbour_px = 2;     ///< an edge is this near
constexpr float kEdgeShare = 0.06F;  ///< change of depth that makes one
constexpr std::uint32_t kFewest = 3;

// 21 bits for each axis: 40 km of 2 cm cubes.
constexpr int kAxisBits = 21;
constexpr std::int64_t kAxisOffset = std::int64_t{1} << (kAxisBits - 1);
constexpr std::uint64_t kAxisMask = (std::uint64_t{1} << kAxisBits) - 1;

std::uint64_t key_of(const std::array<int, 3>& cube) {
  std::uint64_t key = 0;
  for (const int axis : {2, 1, 0}) {
    const auto shifted = static_cast<std::uint64_t>(
        std::int64_t{cube[static_cast<std::size_t>(axis)]} + kAxisOffset);
    key = (key << static_cast<unsigned>(kAxisBits)) | (shifted & kAxisMask);
  }
  return key;
}

std::array<int, 3> cube_of(std::uint64_t key) {
  std::array<int, 3> cube{};
  for (int& axis : cube) {
    axis = static_cast<int>(static_cast<std::int64_t>(key & kAxisMask) - kAxisOffset);
    key >>= static_cast<unsigned>(kAxisBits);
  }
  return cube;
}

}  // namespace

CloudGatherer::CloudGatherer(const CameraModel& camera, double noise_per_m, double cube_m)
    : camera_(camera),
      robot_T_depth_(robot_T_depth_optical(camera)),
      robot_T_colour_(robot_T_colour_optical(camera)),
      light_(linear_light_table()),
      cube_m_(static_cast<float>(cube_m)),
      // The noise of depth is that of its inverse times depth^2.
      least_per_m_(static_cast<float>(std::sqrt(std::max(noise_per_m, 1e-9) / cube_m))) {
  for (int row = kNeighbour_px; row < camera.depth.height_px - kNeighbour_px; row += kEvery) {
    for (int column = kNeighbour_px; column < camera.depth.width_px - kNeighbour_px;
         column += kEvery) {
      rays_.emplace_back(ray_through(camera.depth, Eigen::Vector2d(column, row)).cast<float>());
    }
  }
}

void CloudGatherer::look_from(const Pose3& robot_T_camera) {
  camera_.robot_T_camera = robot_T_camera;
  robot_T_depth_ = robot_T_depth_optical(camera_);
  robot_T_colour_ = robot_T_colour_optical(camera_);
}

void CloudGatherer::add(const RgbdImages& images, const FramePose& pose) {
  const LensModel& lens = colour_lens(camera_);
  const Pose3 map_T_depth = Pose3::from_pose2(pose.map_T_robot_depth) * robot_T_depth_;
  const Pose3 colour_T_map =
      (Pose3::from_pose2(pose.map_T_robot_colour) * robot_T_colour_).inverse();
  const Eigen::Matrix3f map_R_depth = map_T_depth.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f origin = map_T_depth.translation.cast<float>();
  std::size_t ray = 0;
  for (int row = kNeighbour_px; row < images.depth.height - kNeighbour_px; row += kEvery) {
    for (int column = kNeighbour_px; column < images.depth.width - kNeighbour_px;
         column += kEvery, ++ray) {
      const float per_m = images.depth.at(column, row);
      if (per_m < least_per_m_ || per_m <= 0.0F) continue;
      const float left = images.depth.at(column - kNeighbour_px, row);
      const float right = images.depth.at(column + kNeighbour_px, row);
      if (std::abs(left - per_m) > kEdgeShare * per_m ||
          std::abs(right - per_m) > kEdgeShare * per_m) {
        continue;
      }
      const Eigen::Vector3f point = origin + product(map_R_depth, rays_[ray]) / per_m;
      const Eigen::Vector3d in_colour = colour_T_map * Eigen::Vector3d(point.cast<double>());
      if (in_colour.z() < 0.1) continue;
      const Eigen::Vector2d pixel = project(lens, in_colour);
      const auto u = static_cast<int>(std::lround(pixel.x()));
      const auto v = static_cast<int>(std::lround(pixel.y()));
      if (u < 0 || v < 0 || u >= images.colour.width || v >= images.colour.height) continue;
      const std::uint8_t* rgb = images.colour.at(u, v);

      std::array<int, 3> at{};
      for (int axis = 0; axis < 3; ++axis) {
        at[static_cast<std::size_t>(axis)] =
            floor_to_int(static_cast<double>(point[axis]) / static_cast<double>(cube_m_));
      }
      Cube& cube = cubes_[key_of(at)];
      const Eigen::Vector3f corner =
          cube_m_ * Eigen::Vector3f(static_cast<float>(at[0]), static_cast<float>(at[1]),
                                    static_cast<float>(at[2]));
      cube.sum_m += point - corner;
      ++cube.count;
      const LinearRgb light{static_cast<float>(light_[rgb[0]]), static_cast<float>(light_[rgb[1]]),
                            static_cast<float>(light_[rgb[2]])};
      // The nearer view is the sharper one.
      cube.colour.add(light, std::min(1.0F, 0.25F * per_m * per_m));
    }
  }
}

std::vector<ColouredPoint> CloudGatherer::points() const {
  const std::vector<std::uint8_t> srgb = srgb_table();
  std::vector<std::pair<std::array<int, 3>, const Cube*>> kept;
  for (const auto& [key, cube] : cubes_) {
    if (cube.count >= kFewest) kept.emplace_back(cube_of(key), &cube);
  }
  std::sort(kept.begin(), kept.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<ColouredPoint> points;
  points.reserve(kept.size());
  for (const auto& [at, cube] : kept) {
    ColouredPoint point;
    const Eigen::Vector3f corner =
        cube_m_ * Eigen::Vector3f(static_cast<float>(at[0]), static_cast<float>(at[1]),
                                  static_cast<float>(at[2]));
    point.position_m = corner + cube->sum_m / static_cast<float>(cube->count);
    for (std::size_t c = 0; c < 3; ++c) point.rgb[c] = srgb[cube->colour.best.rgb[c]];
    points.push_back(point);
  }
  return points;
}

}  // namespace loopstone
