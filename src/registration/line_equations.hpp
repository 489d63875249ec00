#pragma once

#include <Eigen/Core>

namespace loopstone {

/// The normal equations of point-to-line distances in the plane, H = sum w J^T J and g = sum w r J
/// with J = d r / d (x, y, yaw). Held as single numbers, which stay in registers while a scan is
/// summed up.
class LineEquations {
 public:
  /// \param normal_x, normal_y  of the line, unit
  /// \param arm_x, arm_y        from the source's origin to the point, target axes: turning by dyaw
  ///                            moves the point by dyaw * (-arm_y, arm_x)
  void add(double normal_x, double normal_y, double arm_x, double arm_y, double residual,
           double weight) {
    const double turn = normal_y * arm_x - normal_x * arm_y;
    xx_ += weight * normal_x * normal_x;
    xy_ += weight * normal_x * normal_y;
    yy_ += weight * normal_y * normal_y;
    xw_ += weight * normal_x * turn;
    yw_ += weight * normal_y * turn;
    ww_ += weight * turn * turn;
    x_ += weight * residual * normal_x;
    y_ += weight * residual * normal_y;
    w_ += weight * residual * turn;
  }

  [[nodiscard]] Eigen::Matrix3d hessian() const {
    return (Eigen::Matrix3d() << xx_, xy_, xw_, xy_, yy_, yw_, xw_, yw_, ww_).finished();
  }
  [[nodiscard]] Eigen::Vector3d gradient() const { return {x_, y_, w_}; }

 private:
  double xx_ = 0.0;
  double xy_ = 0.0;
  double yy_ = 0.0;
  double xw_ = 0.0;
  double yw_ = 0.0;
  double ww_ = 0.0;
  double x_ = 0.0;
  double y_ = 0.0;
  double w_ = 0.0;
};

}  // namespace loopstone
