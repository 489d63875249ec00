#include "simulation/camera_view.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "loopstone/base/error.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/sensor/camera_geometry.hpp"

namespace loopstone {
namespace {

/// Bearings at which walls are looked up, for each pixel of a focal length: rays between two of
/// them that see the same wall are exact, others look again.
constexpr double kBearingsPerPixel = 2.0;

/// Where a ray meets the floor, per unit change of its pixel: with p = c + t d and t = -c_z / d_z,
/// dp = t (dd - d dd_z / d_z).
Eigen::Vector2d floor_change(double t, const Eigen::Vector3d& d, const Eigen::Vector3d& dd) {
  return t * (dd - d * (dd.z() / d.z())).head<2>();
}

FloorFootprint footprint_of(double t, const Eigen::Vector3d& d, const Eigen::Vector3d& d_column,
                            const Eigen::Vector3d& d_row) {
  const Eigen::Vector2d u = floor_change(t, d, d_column);
  const Eigen::Vector2d v = floor_change(t, d, d_row);
  // A square pixel: each side contributes the variance of a box.
  const Eigen::Matrix2d covariance = (u * u.transpose() + v * v.transpose()) / 12.0;
  return {static_cast<float>(covariance(0, 0)), static_cast<float>(covariance(0, 1)),
          static_cast<float>(covariance(1, 1))};
}

}  // namespace

CameraView make_camera_view(const LensModel& lens, const Pose3& robot_T_optical) {
  CameraView view;
  view.width = lens.width_px;
  view.height = lens.height_px;
  view.robot_p_camera = robot_T_optical.translation;
  const double height = view.robot_p_camera.z();
  if (!(height > 0.0 && height < CameraView::kCeiling)) {
    throw UsageError("a simulated camera must be above the floor and below " +
                     std::to_string(CameraView::kCeiling) + " m, not at " + std::to_string(height) +
                     " m");
  }
  const Eigen::Matrix3d rotation = robot_T_optical.rotation.toRotationMatrix();
  const Eigen::Vector3d ahead = rotation * Eigen::Vector3d(0.0, 0.0, 1.0);
  const double ahead_yaw = std::atan2(ahead.y(), ahead.x());
  const auto ray_at = [&](double column, double row) -> Eigen::Vector3d {
    return rotation * ray_through(lens, {column, row});
  };
  view.rays.resize(static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height));
  std::vector<float> bearings_rad(view.rays.size());
  std::size_t i = 0;
  for (int row = 0; row < view.height; ++row) {
    for (int column = 0; column < view.width; ++column, ++i) {
      PixelRay& ray = view.rays[i];
      const Eigen::Vector3d d = ray_at(column, row);
      const double horizontal = std::max(d.head<2>().norm(), 1e-6);  // straight down: any bearing
      const double slope = d.z() / horizontal;
      const double flat_height = slope < 0.0 ? height : CameraView::kCeiling - height;
      const double flat_range =
          std::min(CameraView::kFarthest, flat_height / std::max(std::abs(slope), 1e-9));
      ray.direction_x = static_cast<float>(d.x() / horizontal);
      ray.direction_y = static_cast<float>(d.y() / horizontal);
      ray.slope = static_cast<float>(slope);
      ray.depth_per_m =
          static_cast<float>(1.0 / horizontal);  // rays have z = 1 in the optical frame
      ray.flat_range_m = static_cast<float>(flat_range);
      if (slope < 0.0 && flat_range < CameraView::kFarthest) {
        ray.footprint =
            footprint_of(-height / d.z(), d, ray_at(column + 0.5, row) - ray_at(column - 0.5, row),
                         ray_at(column, row + 0.5) - ray_at(column, row - 0.5));
      }
      bearings_rad[i] = static_cast<float>(wrap_angle(std::atan2(d.y(), d.x()) - ahead_yaw));
    }
  }
  const auto [low, high] = std::minmax_element(bearings_rad.begin(), bearings_rad.end());
  view.bearing_step_rad = 1.0 / (kBearingsPerPixel * lens.focal_x_px);
  view.first_bearing_rad = ahead_yaw + static_cast<double>(*low) - 0.5 * view.bearing_step_rad;
  view.bearings =
      static_cast<int>(std::ceil(static_cast<double>(*high - *low) / view.bearing_step_rad)) + 3;
  for (std::size_t k = 0; k < view.rays.size(); ++k) {
    view.rays[k].bearing = static_cast<float>(
        static_cast<double>(bearings_rad[k] - *low) / view.bearing_step_rad + 0.5);
  }
  return view;
}

}  // namespace loopstone
