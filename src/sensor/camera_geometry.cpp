#include "loopstone/sensor/camera_geometry.hpp"

#include <cmath>
#include <cstddef>

namespace loopstone {
namespace {

/// Where the lens puts a ray that would cross z = 1 at (x, y).
Eigen::Vector2d distorted(const LensModel& lens, const Eigen::Vector2d& ideal) {
  const double x = ideal.x();
  const double y = ideal.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  return {x * radial + 2.0 * lens.p1 * x * y + lens.p2 * (r2 + 2.0 * x * x),
          y * radial + lens.p1 * (r2 + 2.0 * y * y) + 2.0 * lens.p2 * x * y};
}

Eigen::Matrix2d distortion_jacobian(const LensModel& lens, const Eigen::Vector2d& ideal) {
  const double x = ideal.x();
  const double y = ideal.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  const double slope = lens.k1 + r2 * (2.0 * lens.k2 + r2 * 3.0 * lens.k3);  // d radial / d r2
  Eigen::Matrix2d j;
  j << radial + 2.0 * x * x * slope + 2.0 * lens.p1 * y + 6.0 * lens.p2 * x,
      2.0 * x * y * slope + 2.0 * lens.p1 * x + 2.0 * lens.p2 * y,
      2.0 * x * y * slope + 2.0 * lens.p1 * x + 2.0 * lens.p2 * y,
      radial + 2.0 * y * y * slope + 6.0 * lens.p1 * y + 2.0 * lens.p2 * x;
  return j;
}

}  // namespace

Eigen::Matrix3d body_R_optical() {
  Eigen::Matrix3d r;
  r << 0.0, 0.0, 1.0,  // forward is the optical z
      -1.0, 0.0, 0.0,  // left is against the optical x
      0.0, -1.0, 0.0;  // up is against the optical y
  return r;
}

Pose3 robot_T_depth_optical(const CameraModel& camera) {
  const Pose3 camera_T_optical{Eigen::Vector3d::Zero(), Eigen::Quaterniond(body_R_optical())};
  return camera.robot_T_camera * camera_T_optical;
}

Pose3 robot_T_colour_optical(const CameraModel& camera) {
  if (camera.colour_is_registered) return robot_T_depth_optical(camera);
  const Pose3 colour_T_optical{Eigen::Vector3d::Zero(), Eigen::Quaterniond(body_R_optical())};
  return camera.robot_T_camera * camera.camera_T_colour * colour_T_optical;
}

const LensModel& colour_lens(const CameraModel& camera) {
  return camera.colour_is_registered ? camera.depth : camera.colour;
}

bool is_distorted(const LensModel& lens) {
  return lens.k1 != 0.0 || lens.k2 != 0.0 || lens.k3 != 0.0 || lens.p1 != 0.0 || lens.p2 != 0.0;
}

Eigen::Vector2d project(const LensModel& lens, const Eigen::Vector3d& p_optical) {
  Eigen::Vector2d at = p_optical.head<2>() / p_optical.z();
  if (is_distorted(lens)) at = distorted(lens, at);
  return {lens.focal_x_px * at.x() + lens.centre_x_px, lens.focal_y_px * at.y() + lens.centre_y_px};
}

Eigen::Vector3d ray_through(const LensModel& lens, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d seen((pixel.x() - lens.centre_x_px) / lens.focal_x_px,
                             (pixel.y() - lens.centre_y_px) / lens.focal_y_px);
  Eigen::Vector2d ideal = seen;
  if (is_distorted(lens)) {
    constexpr int kMostSteps = 20;
    for (int step = 0; step < kMostSteps; ++step) {
      const Eigen::Vector2d residual = distorted(lens, ideal) - seen;
      ideal -= distortion_jacobian(lens, ideal).inverse() * residual;
      if (residual.squaredNorm() < 1e-28) break;
    }
  }
  return {ideal.x(), ideal.y(), 1.0};
}

std::vector<float> inverse_depth_table(const DepthEncoding& encoding) {
  const bool is_disparity = encoding.kind == DepthKind::kDisparity;
  constexpr std::size_t kNumbers = 65536;
  std::vector<float> per_m(kNumbers, 0.0F);
  for (std::size_t number = 1; number < kNumbers; ++number) {
    const auto value = static_cast<double>(number);
    const double inverse = is_disparity
                               ? (encoding.disparity_slope * value + encoding.disparity_offset) /
                                     encoding.disparity_numerator_m
                               : 1.0 / (encoding.metres_per_unit * value);
    if (inverse * encoding.range_max_m >= 1.0 && inverse * encoding.range_min_m <= 1.0) {
      per_m[number] = static_cast<float>(inverse);
    }
  }
  return per_m;
}

}  // namespace loopstone
