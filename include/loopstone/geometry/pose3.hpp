#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// A rigid motion of space, SE(3). `a_T_b` maps coordinates of frame b to frame a.
struct Pose3 {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();         ///< [m]
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< unit

  [[nodiscard]] Pose3 inverse() const;
  /// REP-103 fixed axes: rotation = Rz(yaw) * Ry(pitch) * Rx(roll) [rad].
  [[nodiscard]] static Pose3 from_roll_pitch_yaw(const Eigen::Vector3d& translation, double roll,
                                                 double pitch, double yaw);
  /// The planar pose lifted to z = 0.
  [[nodiscard]] static Pose3 from_pose2(const Pose2& pose);
};

[[nodiscard]] Pose3 operator*(const Pose3& a_T_b, const Pose3& b_T_c);
[[nodiscard]] Eigen::Vector3d operator*(const Pose3& a_T_b, const Eigen::Vector3d& p_b);

/// Translation first, then rotation vector [m, rad].
using Tangent3 = Eigen::Matrix<double, 6, 1>;

[[nodiscard]] Pose3 exp(const Tangent3& twist);
[[nodiscard]] Tangent3 log(const Pose3& pose);
/// exp(adjoint(a_T_b) * xi_b) * a_T_b == a_T_b * exp(xi_b).
[[nodiscard]] Eigen::Matrix<double, 6, 6> adjoint(const Pose3& a_T_b);

/// x, y and heading of the x axis, dropping z, roll and pitch.
[[nodiscard]] Pose2 project_to_plane(const Pose3& pose);

}  // namespace loopstone
