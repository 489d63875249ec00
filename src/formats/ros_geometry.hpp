#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/geometry/pose3.hpp"
#include "loopstone/messages/message_types.hpp"

// Geometry as messages hold it, and as ours.

namespace loopstone {

[[nodiscard]] inline Eigen::Vector3d to_eigen(const msg::Vector3& v) { return {v.x, v.y, v.z}; }
[[nodiscard]] inline Eigen::Vector3d to_eigen(const msg::Point& p) { return {p.x, p.y, p.z}; }

/// Nothing when it is no pose: not finite, or a rotation of length zero.
[[nodiscard]] inline std::optional<Pose3> to_pose3(const Eigen::Vector3d& translation,
                                                   const msg::Quaternion& rotation) {
  const Eigen::Quaterniond q(rotation.w, rotation.x, rotation.y, rotation.z);
  const double norm = q.norm();
  if (!translation.allFinite() || !std::isfinite(norm) || norm < 1e-6) return std::nullopt;
  return Pose3{translation, q.normalized()};
}
[[nodiscard]] inline std::optional<Pose3> to_pose3(const msg::Transform& transform) {
  return to_pose3(to_eigen(transform.translation), transform.rotation);
}
[[nodiscard]] inline std::optional<Pose3> to_pose3(const msg::Pose& pose) {
  return to_pose3(to_eigen(pose.position), pose.orientation);
}

/// What remains of a pose in the plane: where x points, seen from above.
[[nodiscard]] inline Pose2 to_pose2(const Pose3& pose) {
  const Eigen::Vector3d forward = pose.rotation * Eigen::Vector3d::UnitX();
  return {pose.translation.x(), pose.translation.y(), std::atan2(forward.y(), forward.x())};
}

/// Turned only about z.
[[nodiscard]] inline msg::Quaternion to_quaternion(double yaw_rad) {
  return {.z = std::sin(0.5 * yaw_rad), .w = std::cos(0.5 * yaw_rad)};
}

}  // namespace loopstone
