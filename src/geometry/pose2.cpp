#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

namespace {

/// sin(w)/w and (1-cos(w))/w, safe near zero.
struct ArcFactors {
  double sine;
  double cosine;
};

ArcFactors arc_factors(double w) {
  if (std::abs(w) < 1e-4) {
    const double w2 = w * w;
    return {1.0 - w2 / 6.0, w * (0.5 - w2 / 24.0)};
  }
  const double half_sine = std::sin(0.5 * w);
  return {std::sin(w) / w, 2.0 * half_sine * half_sine / w};
}

}  // namespace

Pose2 exp(const Tangent2& twist) {
  const double w = twist.z();
  const auto [s, c] = arc_factors(w);
  return {s * twist.x() - c * twist.y(), c * twist.x() + s * twist.y(), wrap_angle(w)};
}

Tangent2 log(const Pose2& pose) {
  const auto [s, c] = arc_factors(pose.yaw);
  const double norm2 = s * s + c * c;
  return {(s * pose.x + c * pose.y) / norm2, (-c * pose.x + s * pose.y) / norm2, pose.yaw};
}

Eigen::Matrix3d adjoint(const Pose2& a_T_b) {
  Eigen::Matrix3d result = Eigen::Matrix3d::Identity();
  result.topLeftCorner<2, 2>() = a_T_b.rotation();
  result(0, 2) = a_T_b.y;
  result(1, 2) = -a_T_b.x;
  return result;
}

Eigen::Matrix3d compose_jacobian_left(const Pose2& a, const Pose2& b) {
  const double c = std::cos(a.yaw);
  const double s = std::sin(a.yaw);
  Eigen::Matrix3d result = Eigen::Matrix3d::Identity();
  result(0, 2) = -s * b.x - c * b.y;
  result(1, 2) = c * b.x - s * b.y;
  return result;
}

Eigen::Matrix3d compose_jacobian_right(const Pose2& a, const Pose2& /*b*/) {
  Eigen::Matrix3d result = Eigen::Matrix3d::Identity();
  result.topLeftCorner<2, 2>() = a.rotation();
  return result;
}

Eigen::Matrix3d inverse_jacobian(const Pose2& a) {
  const double c = std::cos(a.yaw);
  const double s = std::sin(a.yaw);
  return (Eigen::Matrix3d() << -c, -s, s * a.x - c * a.y,  //
          s, -c, c * a.x + s * a.y,                        //
          0.0, 0.0, -1.0)
      .finished();
}

Pose2 interpolate(const Pose2& from, const Pose2& to, double ratio) {
  return from * exp(ratio * log(from.inverse() * to));
}

PoseWithCovariance2 compound(const PoseWithCovariance2& a_T_b, const PoseWithCovariance2& b_T_c) {
  const Eigen::Matrix3d left = compose_jacobian_left(a_T_b.pose, b_T_c.pose);
  const Eigen::Matrix3d right = compose_jacobian_right(a_T_b.pose, b_T_c.pose);
  return {a_T_b.pose * b_T_c.pose, left * a_T_b.covariance * left.transpose() +
                                       right * b_T_c.covariance * right.transpose()};
}

PoseWithCovariance2 inverse(const PoseWithCovariance2& a_T_b) {
  const Eigen::Matrix3d jacobian = inverse_jacobian(a_T_b.pose);
  return {a_T_b.pose.inverse(), jacobian * a_T_b.covariance * jacobian.transpose()};
}

}  // namespace loopstone
