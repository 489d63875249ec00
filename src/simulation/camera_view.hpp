#pragma once

#include <Eigen/Core>
#include <vector>

#include "loopstone/geometry/pose3.hpp"
#include "loopstone/sensor/camera_model.hpp"
#include "loopstone/simulation/floor_pattern.hpp"

namespace loopstone {

/// The ray of one pixel, on the robot: what does not change while the robot drives on a flat floor.
struct PixelRay {
  float direction_x = 1.0F;  ///< horizontal part, unit length, robot frame
  float direction_y = 0.0F;
  float bearing =
      0.0F;            ///< of that, in steps of CameraView::bearing_step_rad from its first bearing
  float slope = 0.0F;  ///< rises so much for each horizontal metre
  float depth_per_m = 1.0F;    ///< depth along the optical axis for each horizontal metre
  float flat_range_m = 0.0F;   ///< horizontal range to floor or ceiling, at most kFarthest
  FloorFootprint footprint{};  ///< of the pixel on the floor, robot frame
};

/// All rays of a camera on a robot.
struct CameraView {
  static constexpr double kFarthest = 60.0;  ///< nothing beyond is drawn [m]
  static constexpr double kCeiling = 2.5;    ///< height [m]

  int width = 0;
  int height = 0;
  Eigen::Vector3d robot_p_camera{0.0, 0.0, 0.0};
  double first_bearing_rad = 0.0;  ///< robot frame
  double bearing_step_rad = 0.0;
  int bearings = 0;  ///< every ray's bearing lies in [0, bearings - 1)
  std::vector<PixelRay> rays{};
};

[[nodiscard]] CameraView make_camera_view(const LensModel& lens, const Pose3& robot_T_optical);

}  // namespace loopstone
