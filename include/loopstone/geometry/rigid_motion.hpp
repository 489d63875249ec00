#pragma once

#include <Eigen/Core>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/geometry/pose3.hpp"

namespace loopstone {

/// The rigid motions of the plane (kDimension 2) and of space (3), under one set of names, so that
/// an algorithm that is the same in both is written once.
///
/// A small motion (dt, dw) of a pose a_T_b moves frame b by dt and turns it by dw about b's own
/// origin, both on the axes of frame a: dw is one angle in the plane, a rotation vector in space.
/// In the plane the pose's (x, y, yaw) simply grow by the motion. Covariances of poses are those of
/// this motion.
template <int kDimension>
struct RigidMotion;

template <>
struct RigidMotion<2> {
  using Pose = Pose2;
  static constexpr int kDof = 3;
  using Vector = Eigen::Vector2d;
  using Matrix = Eigen::Matrix2d;
  using Tangent = Eigen::Vector3d;

  [[nodiscard]] static Matrix rotation(const Pose& pose) { return pose.rotation(); }
  [[nodiscard]] static Vector translation(const Pose& pose) { return pose.translation(); }
  [[nodiscard]] static Pose pose(const Matrix& rotation, const Vector& translation) {
    return {translation.x(), translation.y(),
            wrap_angle(std::atan2(rotation(1, 0), rotation(0, 0)))};
  }
  [[nodiscard]] static Pose moved(const Pose& pose, const Tangent& motion) {
    return {pose.x + motion.x(), pose.y + motion.y(), wrap_angle(pose.yaw + motion.z())};
  }
  /// The motion that brings `from` to `pose`: moved(from, difference(pose, from)) == pose.
  [[nodiscard]] static Tangent difference(const Pose& pose, const Pose& from) {
    return {pose.x - from.x, pose.y - from.y, wrap_angle(pose.yaw - from.yaw)};
  }
  /// How a point moves with the pose; `arm` runs from b's origin to the point, on the axes of a.
  [[nodiscard]] static Eigen::Matrix<double, 2, 3> point_jacobian(const Vector& arm) {
    return (Eigen::Matrix<double, 2, 3>() << 1.0, 0.0, -arm.y(), 0.0, 1.0, arm.x()).finished();
  }
};

template <>
struct RigidMotion<3> {
  using Pose = Pose3;
  static constexpr int kDof = 6;
  using Vector = Eigen::Vector3d;
  using Matrix = Eigen::Matrix3d;
  using Tangent = Tangent3;

  [[nodiscard]] static Matrix rotation(const Pose& pose) {
    return pose.rotation.toRotationMatrix();
  }
  [[nodiscard]] static Vector translation(const Pose& pose) { return pose.translation; }
  [[nodiscard]] static Pose pose(const Matrix& rotation, const Vector& translation) {
    return {translation, Eigen::Quaterniond(rotation).normalized()};
  }
  [[nodiscard]] static Pose moved(const Pose& pose, const Tangent& motion) {
    Tangent turn = Tangent::Zero();
    turn.tail<3>() = motion.tail<3>();
    return {pose.translation + motion.head<3>(), (exp(turn).rotation * pose.rotation).normalized()};
  }
  [[nodiscard]] static Tangent difference(const Pose& pose, const Pose& from) {
    Tangent motion = log(Pose{Vector::Zero(), pose.rotation * from.rotation.conjugate()});
    motion.head<3>() = pose.translation - from.translation;
    return motion;
  }
  [[nodiscard]] static Eigen::Matrix<double, 3, 6> point_jacobian(const Vector& arm) {
    Eigen::Matrix<double, 3, 6> jacobian;
    jacobian << 1.0, 0.0, 0.0, 0.0, arm.z(), -arm.y(),  //
        0.0, 1.0, 0.0, -arm.z(), 0.0, arm.x(),          //
        0.0, 0.0, 1.0, arm.y(), -arm.x(), 0.0;
    return jacobian;
  }
};

}  // namespace loopstone
