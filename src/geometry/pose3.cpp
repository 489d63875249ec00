#include "loopstone/geometry/pose3.hpp"

#include <cmath>

namespace loopstone {

namespace {

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  return (Eigen::Matrix3d() << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0)
      .finished();
}

/// V of Barfoot 2017, eq. 7.86: translation of exp = V * rho.
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  const Eigen::Matrix3d k = skew(phi);
  double a = 0.0;  // (1 - cos) / angle^2
  double b = 0.0;  // (angle - sin) / angle^3
  if (angle < 1e-3) {
    a = 0.5 - angle * angle / 24.0;
    b = 1.0 / 6.0 - angle * angle / 120.0;
  } else {
    a = (1.0 - std::cos(angle)) / (angle * angle);
    b = (angle - std::sin(angle)) / (angle * angle * angle);
  }
  return Eigen::Matrix3d::Identity() + a * k + b * k * k;
}

Eigen::Quaterniond quaternion_exp(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  const double half = 0.5 * angle;
  const double factor = angle < 1e-8 ? 0.5 : std::sin(half) / angle;
  return Eigen::Quaterniond(std::cos(half), factor * phi.x(), factor * phi.y(), factor * phi.z());
}

Eigen::Vector3d quaternion_log(Eigen::Quaterniond q) {
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  const double factor = sine < 1e-10 ? 2.0 / q.w() : 2.0 * std::atan2(sine, q.w()) / sine;
  return factor * q.vec();
}

}  // namespace

Pose3 Pose3::inverse() const {
  const Eigen::Quaterniond inverse_rotation = rotation.conjugate();
  return {-(inverse_rotation * translation), inverse_rotation};
}

Pose3 Pose3::from_roll_pitch_yaw(const Eigen::Vector3d& translation, double roll, double pitch,
                                 double yaw) {
  return {translation, Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                           Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                           Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX())};
}

Pose3 Pose3::from_pose2(const Pose2& pose) {
  return from_roll_pitch_yaw({pose.x, pose.y, 0.0}, 0.0, 0.0, pose.yaw);
}

Pose3 operator*(const Pose3& a_T_b, const Pose3& b_T_c) {
  return {a_T_b.translation + a_T_b.rotation * b_T_c.translation,
          (a_T_b.rotation * b_T_c.rotation).normalized()};
}

Eigen::Vector3d operator*(const Pose3& a_T_b, const Eigen::Vector3d& p_b) {
  return a_T_b.translation + a_T_b.rotation * p_b;
}

Pose3 exp(const Tangent3& twist) {
  const Eigen::Vector3d phi = twist.tail<3>();
  return {left_jacobian(phi) * twist.head<3>(), quaternion_exp(phi)};
}

Tangent3 log(const Pose3& pose) {
  const Eigen::Vector3d phi = quaternion_log(pose.rotation);
  Tangent3 result;
  result.head<3>() = left_jacobian(phi).inverse() * pose.translation;
  result.tail<3>() = phi;
  return result;
}

Eigen::Matrix<double, 6, 6> adjoint(const Pose3& a_T_b) {
  const Eigen::Matrix3d r = a_T_b.rotation.toRotationMatrix();
  Eigen::Matrix<double, 6, 6> result = Eigen::Matrix<double, 6, 6>::Zero();
  result.topLeftCorner<3, 3>() = r;
  result.topRightCorner<3, 3>() = skew(a_T_b.translation) * r;
  result.bottomRightCorner<3, 3>() = r;
  return result;
}

Pose2 project_to_plane(const Pose3& pose) {
  const Eigen::Vector3d heading = pose.rotation * Eigen::Vector3d::UnitX();
  return {pose.translation.x(), pose.translation.y(), std::atan2(heading.y(), heading.x())};
}

}  // namespace loopstone
