#pragma once

#include "loopstone/base/words.hpp"
#include "loopstone/geometry/pose3.hpp"

namespace loopstone {

/// A pinhole with the lens distortion of Brown and Conrady (radial k1 k2 k3, tangential p1 p2, as
/// OpenCV orders and names them). The centre of the first pixel is (0, 0); columns u grow to the
/// right, rows v down.
struct LensModel {
  double focal_x_px = 585.05108211;
  double focal_y_px = 585.05108211;
  double centre_x_px = 315.83800193;  ///< column of the optical axis
  double centre_y_px = 242.94140713;  ///< row of the optical axis
  int width_px = 640;
  int height_px = 480;
  double k1 = 0.0;
  double k2 = 0.0;
  double p1 = 0.0;
  double p2 = 0.0;
  double k3 = 0.0;
};

enum class DepthKind {
  kDisparity,  ///< depth = numerator / (slope * number + offset)
  kDepth,      ///< depth = metres_per_unit * number
};

constexpr auto words_of(DepthKind /*any*/) {
  using enum DepthKind;
  return std::array{Word{kDisparity, "disparity"}, Word{kDepth, "depth"}};
}

/// What the numbers of a depth picture mean. Depth is measured along the optical axis, not along
/// the ray. 0 is no measurement.
struct DepthEncoding {
  DepthKind kind = DepthKind::kDisparity;
  double disparity_slope = -0.00304;
  double disparity_offset = 3.31;
  double disparity_numerator_m = 1.03;
  double metres_per_unit = 0.001;
  double range_min_m = 0.4;  ///< depths outside are no measurement
  double range_max_m = 10.0;
};

/// A camera that measures depth and a camera that sees colour, side by side. The frames `camera`
/// and `colour` are body-like (x forward, y left, z up), as the robot's; the optical frames (z
/// forward, x right, y down) follow from them by camera_geometry.hpp. `camera` is the depth camera.
///
/// The defaults are the UCSD robot's Kinect. Its published registration,
///   column = (526.37 u + 19276 - 7877.07 dd) / 585.051, row = (526.37 v + 16662) / 585.051, depth
///   = 1.03 / dd,
/// is that of a pinhole of focal length 526.37 at (317.107, 247.054), which sits
/// (7877.07 / 585.051) * 1.03 / 526.37 = 0.026346 m to the right of the depth camera and looks the
/// same way.
struct CameraModel {
  Pose3 robot_T_camera = Pose3::from_roll_pitch_yaw({0.18, 0.005, 0.36}, 0.0, 0.36, 0.021);
  LensModel depth{};
  DepthEncoding encoding{};
  Pose3 camera_T_colour{{0.0, -0.026346144805578384, 0.0}, Eigen::Quaterniond::Identity()};
  LensModel colour{.focal_x_px = 526.370073874313,
                   .focal_y_px = 526.370073874313,
                   .centre_x_px = 317.1067976567754,
                   .centre_y_px = 247.053792696736};
  bool colour_is_registered = false;  ///< colour pictures are already in the depth camera's pixels
};

}  // namespace loopstone
