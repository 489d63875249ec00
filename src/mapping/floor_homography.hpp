#pragma once

#include <Eigen/Core>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/geometry/pose3.hpp"
#include "loopstone/sensor/camera_geometry.hpp"

namespace loopstone {

/// From a point (x, y, 1) of the map's floor to its pixel, homogeneous; the third element is the
/// depth along the optical axis. For a distorted lens it is the pixel of a picture at focal length
/// 1, still to be distorted.
/// Source: Hartley and Zisserman 2004, "Multiple view geometry", section 8.1.1.
[[nodiscard]] inline Eigen::Matrix3d floor_homography(const LensModel& lens,
                                                      const Pose2& map_T_robot,
                                                      const Pose3& robot_T_optical) {
  const Pose3 optical_T_map = (Pose3::from_pose2(map_T_robot) * robot_T_optical).inverse();
  const Eigen::Matrix3d r = optical_T_map.rotation.toRotationMatrix();
  Eigen::Matrix3d h;
  h << r.col(0), r.col(1), optical_T_map.translation;
  if (is_distorted(lens)) return h;
  Eigen::Matrix3d k;
  k << lens.focal_x_px, 0.0, lens.centre_x_px, 0.0, lens.focal_y_px, lens.centre_y_px, 0.0, 0.0,
      1.0;
  return k * h;
}

}  // namespace loopstone
