#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "loopstone/base/linear_light.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/geometry/pose3.hpp"
#include "loopstone/sensor/camera_geometry.hpp"
#include "loopstone/sensor/camera_model.hpp"
#include "loopstone/sensor/rgbd_images.hpp"

namespace loopstone::test {

/// Linear light, 0 to 1, of a point of the floor in the map frame.
using FloorColour = std::function<Eigen::Vector3d(double x_m, double y_m)>;

/// Something that stands on the floor; its sides are the map's axes.
struct StandingBox {
  Eigen::Vector3d low;
  Eigen::Vector3d high;
  Eigen::Vector3d light{0.8, 0.05, 0.05};
};

struct FloorScene {
  FloorColour colour;
  std::vector<StandingBox> boxes{};
};

/// Where a ray meets the scene: distance in units of the ray, light.
struct Met {
  double distance = std::numeric_limits<double>::infinity();
  Eigen::Vector3d light = Eigen::Vector3d::Zero();
};

inline Met meet(const FloorScene& scene, const Eigen::Vector3d& origin,
                const Eigen::Vector3d& ray) {
  Met met;
  if (ray.z() < 0.0) {
    met.distance = -origin.z() / ray.z();
    const Eigen::Vector3d at = origin + met.distance * ray;
    met.light = scene.colour(at.x(), at.y());
  }
  for (const StandingBox& box : scene.boxes) {
    const Eigen::Array3d a = (box.low - origin).array() / ray.array();
    const Eigen::Array3d b = (box.high - origin).array() / ray.array();
    const double near = a.min(b).maxCoeff();
    const double far = a.max(b).minCoeff();
    if (near <= far && near > 0.0 && near < met.distance) met = {near, box.light};
  }
  return met;
}

/// The defaults at a quarter of the size, so that tests are fast.
inline CameraModel small_camera() {
  CameraModel camera;
  for (LensModel* lens : {&camera.depth, &camera.colour}) {
    lens->focal_x_px /= 4.0;
    lens->focal_y_px /= 4.0;
    lens->centre_x_px = (lens->centre_x_px + 0.5) / 4.0 - 0.5;
    lens->centre_y_px = (lens->centre_y_px + 0.5) / 4.0 - 0.5;
    lens->width_px /= 4;
    lens->height_px /= 4;
  }
  return camera;
}

/// The slow and plain way to a frame: each pixel's rays one by one, straight from project's
/// inverse. Depth numbers are rounded to whole steps when `quantised`.
/// \param samples  rays a pixel in each direction, for colour
inline RgbdImages render(const FloorScene& scene, const CameraModel& camera,
                         const Pose2& map_T_robot_depth, const Pose2& map_T_robot_colour,
                         int samples = 2, bool quantised = false) {
  RgbdImages images;
  const Pose3 map_T_depth = Pose3::from_pose2(map_T_robot_depth) * robot_T_depth_optical(camera);
  images.depth = {camera.depth.width_px, camera.depth.height_px, {}};
  const DepthEncoding& encoding = camera.encoding;
  for (int row = 0; row < camera.depth.height_px; ++row) {
    for (int column = 0; column < camera.depth.width_px; ++column) {
      const Eigen::Vector3d ray =
          map_T_depth.rotation * ray_through(camera.depth, Eigen::Vector2d(column, row));
      double per_m = 1.0 / meet(scene, map_T_depth.translation, ray).distance;
      if (quantised) {
        const double step = encoding.disparity_slope / encoding.disparity_numerator_m;
        const double start = encoding.disparity_offset / encoding.disparity_numerator_m;
        per_m = std::round((per_m - start) / step) * step + start;
      }
      const bool measured =
          per_m * encoding.range_max_m >= 1.0 && per_m * encoding.range_min_m <= 1.0;
      images.depth.per_m.push_back(measured ? static_cast<float>(per_m) : 0.0F);
    }
  }
  const LensModel& lens = colour_lens(camera);
  const Pose3 map_T_colour = Pose3::from_pose2(map_T_robot_colour) * robot_T_colour_optical(camera);
  images.colour = {lens.width_px, lens.height_px, {}};
  for (int row = 0; row < lens.height_px; ++row) {
    for (int column = 0; column < lens.width_px; ++column) {
      Eigen::Vector3d light = Eigen::Vector3d::Zero();
      for (int i = 0; i < samples * samples; ++i) {
        const Eigen::Vector2d pixel(column - 0.5 + (i % samples + 0.5) / samples,
                                    row - 0.5 + (i / samples + 0.5) / samples);
        light +=
            meet(scene, map_T_colour.translation, map_T_colour.rotation * ray_through(lens, pixel))
                .light;
      }
      light /= samples * samples;
      for (int c = 0; c < 3; ++c) {
        images.colour.rgb.push_back(static_cast<std::uint8_t>(
            std::lround(255.0 * srgb_of_linear(std::clamp(light[c], 0.0, 1.0)))));
      }
    }
  }
  return images;
}

/// A smooth floor on which no two places look alike, and with structure down to about 5 cm.
inline Eigen::Vector3d wavy_floor(double x, double y) {
  const double a = 0.5 + 0.2 * std::sin(31.0 * x + 4.0 * y) + 0.2 * std::sin(43.0 * y - 9.0 * x);
  const double b = 0.5 + 0.4 * std::sin(3.1 * x) * std::cos(2.3 * y);
  return {a, 0.5 * a + 0.4 * b, b};
}

}  // namespace loopstone::test
