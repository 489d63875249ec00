#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "loopstone/sensor/camera_geometry.hpp"
#include "loopstone/sensor/camera_model.hpp"

namespace loopstone {

/// A square of floor as the colour picture shows it: an upright box of the outline's variances; at
/// least a pixel, which is to interpolate between pixels.
struct FloorBox {
  float u = 0.0F;  ///< of the middle
  float v = 0.0F;
  float width = 1.0F;
  float height = 1.0F;
  Eigen::RowVector2f u_xy = Eigen::RowVector2f::Zero();  ///< how u moves with the square [px/m]
  Eigen::RowVector2f v_xy = Eigen::RowVector2f::Zero();
};

/// From what floor_homography gives to pixels, through the two lenses of a camera.
class FloorLenses {
 public:
  explicit FloorLenses(const CameraModel& camera)
      : colour_(colour_lens(camera)),
        depth_(camera.depth),
        colour_is_distorted_(is_distorted(colour_)),
        depth_is_distorted_(is_distorted(depth_)) {}

  /// \param homography  of the colour picture
  /// \param seen        homography * (x, y, 1) of the square's middle
  [[nodiscard]] FloorBox box(const Eigen::Matrix3f& homography, const Eigen::Vector3f& seen,
                             float side_m) const {
    FloorBox box;
    const float per_z = 1.0F / seen.z();
    box.u = seen.x() * per_z;
    box.v = seen.y() * per_z;
    box.u_xy = (homography.row(0).head<2>() - box.u * homography.row(2).head<2>()) * per_z;
    box.v_xy = (homography.row(1).head<2>() - box.v * homography.row(2).head<2>()) * per_z;
    if (colour_is_distorted_) {
      const Eigen::Vector2f at = project(colour_, Eigen::Vector3d(box.u, box.v, 1.0)).cast<float>();
      box.u = at.x();
      box.v = at.y();
      box.u_xy *= static_cast<float>(colour_.focal_x_px);
      box.v_xy *= static_cast<float>(colour_.focal_y_px);
    }
    box.width = std::max(1.0F, side_m * box.u_xy.norm());
    box.height = std::max(1.0F, side_m * box.v_xy.norm());
    return box;
  }
  /// Whether a box lies within the colour picture, below the rows that are not read.
  [[nodiscard]] bool shows(const FloorBox& box, float first_row = 0.0F) const {
    return box.u - 0.5F * box.width >= 0.0F && box.v - 0.5F * box.height >= first_row &&
           box.u + 0.5F * box.width <= static_cast<float>(colour_.width_px - 1) &&
           box.v + 0.5F * box.height <= static_cast<float>(colour_.height_px - 1);
  }
  /// Pixel of the depth picture. \param seen  its homography * (x, y, 1)
  [[nodiscard]] Eigen::Vector2f depth_pixel(const Eigen::Vector3f& seen) const {
    Eigen::Vector2f pixel(seen.x() / seen.z(), seen.y() / seen.z());
    if (depth_is_distorted_) {
      pixel = project(depth_, Eigen::Vector3d(pixel.x(), pixel.y(), 1.0)).cast<float>();
    }
    return pixel;
  }

 private:
  LensModel colour_;
  LensModel depth_;
  bool colour_is_distorted_;
  bool depth_is_distorted_;
};

}  // namespace loopstone
