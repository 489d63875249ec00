#pragma once

#include <Eigen/Core>
#include <vector>

#include "loopstone/geometry/pose3.hpp"
#include "loopstone/sensor/camera_model.hpp"

namespace loopstone {

/// Rotation from an optical frame (z forward, x right, y down) to its body-like frame (x forward, y
/// left, z up).
[[nodiscard]] Eigen::Matrix3d body_R_optical();

/// Where the optical frame of the depth camera lies on the robot.
[[nodiscard]] Pose3 robot_T_depth_optical(const CameraModel& camera);
/// The same of the colour camera; that of the depth camera when the pictures are registered to it.
[[nodiscard]] Pose3 robot_T_colour_optical(const CameraModel& camera);
/// The lens that colour pictures were taken with, or registered to.
[[nodiscard]] const LensModel& colour_lens(const CameraModel& camera);

[[nodiscard]] bool is_distorted(const LensModel& lens);

/// Pixel (column, row) at which a point of the optical frame is seen; z must be positive.
/// Source: Brown 1966, "Decentering distortion of lenses"; the form is OpenCV's.
[[nodiscard]] Eigen::Vector2d project(const LensModel& lens, const Eigen::Vector3d& p_optical);

/// The point at z = 1 of the optical frame that is seen at a pixel: the inverse of project, by
/// Newton's method when the lens is distorted (to 1e-10 within the picture of any usual lens).
[[nodiscard]] Eigen::Vector3d ray_through(const LensModel& lens, const Eigen::Vector2d& pixel);

/// 1 / depth [1/m] of every 16-bit number of a depth picture; 0 for what is no measurement.
[[nodiscard]] std::vector<float> inverse_depth_table(const DepthEncoding& encoding);

}  // namespace loopstone
