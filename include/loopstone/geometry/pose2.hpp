#pragma once

#include <Eigen/Core>
#include <cmath>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {

/// A rigid motion of the plane, SE(2): a rotation by yaw followed by a translation.
/// `a_T_b` maps coordinates of frame b to frame a: p_a = a_T_b * p_b, and a_T_c = a_T_b * b_T_c.
struct Pose2 {
  double x = 0.0;    ///< [m]
  double y = 0.0;    ///< [m]
  double yaw = 0.0;  ///< [rad], counter-clockwise, kept in (-pi, pi]

  [[nodiscard]] Eigen::Vector2d translation() const { return {x, y}; }
  [[nodiscard]] Eigen::Matrix2d rotation() const {
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    return (Eigen::Matrix2d() << c, -s, s, c).finished();
  }
  [[nodiscard]] Pose2 inverse() const {
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    return {-c * x - s * y, s * x - c * y, wrap_angle(-yaw)};
  }
  [[nodiscard]] Eigen::Vector3d vector() const { return {x, y, yaw}; }
  friend bool operator==(const Pose2&, const Pose2&) = default;

  template <typename Archive>
  void archive(Archive& a) {
    a(x, y, yaw);
  }
};

[[nodiscard]] inline Pose2 operator*(const Pose2& a_T_b, const Pose2& b_T_c) {
  const double c = std::cos(a_T_b.yaw);
  const double s = std::sin(a_T_b.yaw);
  return {a_T_b.x + c * b_T_c.x - s * b_T_c.y, a_T_b.y + s * b_T_c.x + c * b_T_c.y,
          wrap_angle(a_T_b.yaw + b_T_c.yaw)};
}

[[nodiscard]] inline Eigen::Vector2d operator*(const Pose2& a_T_b, const Eigen::Vector2d& p_b) {
  const double c = std::cos(a_T_b.yaw);
  const double s = std::sin(a_T_b.yaw);
  return {a_T_b.x + c * p_b.x() - s * p_b.y(), a_T_b.y + s * p_b.x() + c * p_b.y()};
}

/// A velocity or small motion [m, m, rad] in the moving frame, the tangent space se(2).
using Tangent2 = Eigen::Vector3d;

/// The motion along a constant twist for unit time: a circular arc. Inverse of log.
[[nodiscard]] Pose2 exp(const Tangent2& twist);
/// The twist whose exp is the pose; yaw in (-pi, pi].
[[nodiscard]] Tangent2 log(const Pose2& pose);

/// Adjoint: exp(adjoint(a_T_b) * xi_b) * a_T_b == a_T_b * exp(xi_b).
[[nodiscard]] Eigen::Matrix3d adjoint(const Pose2& a_T_b);

/// Jacobians of c = a * b, the coordinates of every pose being (x, y, yaw) as stored.
[[nodiscard]] Eigen::Matrix3d compose_jacobian_left(const Pose2& a, const Pose2& b);
[[nodiscard]] Eigen::Matrix3d compose_jacobian_right(const Pose2& a, const Pose2& b);
/// Jacobian of a.inverse() with respect to a, coordinates (x, y, yaw).
[[nodiscard]] Eigen::Matrix3d inverse_jacobian(const Pose2& a);

/// Between two poses: ratio 0 gives `from`, 1 gives `to`; along the arc from.inverse() * to.
/// Extrapolates.
[[nodiscard]] Pose2 interpolate(const Pose2& from, const Pose2& to, double ratio);

/// A pose and how well it is known: covariance of (x, y, yaw) in the pose's parent frame [m^2, m
/// rad, rad^2].
struct PoseWithCovariance2 {
  Pose2 pose;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();

  template <typename Archive>
  void archive(Archive& a) {
    a(pose, covariance);
  }
};

/// a_T_c and its covariance from independent a_T_b and b_T_c, to first order
/// (Smith, Self and Cheeseman 1990, "Estimating uncertain spatial relationships", compounding).
[[nodiscard]] PoseWithCovariance2 compound(const PoseWithCovariance2& a_T_b,
                                           const PoseWithCovariance2& b_T_c);
/// The inverse pose and its covariance, to first order.
[[nodiscard]] PoseWithCovariance2 inverse(const PoseWithCovariance2& a_T_b);

}  // namespace loopstone
