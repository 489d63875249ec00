#include "loopstone/geometry/line_alignment.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "loopstone/base/hypotenuse.hpp"

namespace loopstone {

namespace {

/// Relative to the greatest eigenvalue: less is nothing.
constexpr double kNothing = 1e-12;

struct UnitMinimiser {
  Eigen::Vector2d direction;
  bool unique = false;
};

/// The unit vector r that minimises r^T S r - 2 u^T r. Stationary points solve (S + lambda I) r =
/// u; in the eigenbasis of S, |r| = 1 reads u_1^2 / (s_1 + lambda)^2 + u_2^2 / (s_2 + lambda)^2 =
/// 1, a quartic in lambda. The minimum belongs to its greatest root, the one that leaves S + lambda
/// I without a negative eigenvalue (Forsythe and Golub 1965).
UnitMinimiser minimise_on_circle(const Eigen::Matrix2d& s_matrix, const Eigen::Vector2d& u_vector) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen;
  eigen.computeDirect(s_matrix);
  const Eigen::Vector2d s = eigen.eigenvalues();  // ascending
  const Eigen::Vector2d u = eigen.eigenvectors().transpose() * u_vector;
  const double scale = std::max(std::abs(s(1)), u.norm());
  if (!(scale > 0.0)) return {{1.0, 0.0}, false};
  // The root lies between these: at the lower one the first term alone is 1, at the upper one the
  // sum is at most 1.
  double low = -s(0) + std::abs(u(0));
  double high = -s(0) + u.norm();
  Eigen::Vector2d r;
  if (std::abs(u(0)) <= kNothing * scale && std::abs(u(1)) < s(1) - s(0)) {
    // Two minima, mirror images; none is better than the other.
    r(1) = u(1) / (s(1) - s(0));
    r(0) = std::sqrt(std::max(0.0, 1.0 - r(1) * r(1)));
    return {eigen.eigenvectors() * r, false};
  }
  const auto length_at = [&](double lambda) {
    const double first = u(0) / (s(0) + lambda);
    const double second = u(1) / (s(1) + lambda);
    return hypotenuse(s(0) + lambda > 0.0 ? first : 0.0, s(1) + lambda > 0.0 ? second : 0.0);
  };
  // Newton on 1 / |r| - 1, which is nearly straight, kept between the bounds.
  double lambda = low;
  for (int step = 0; step < 100; ++step) {
    const double length = length_at(lambda);
    if (length >= 1.0) low = std::max(low, lambda);
    if (length <= 1.0) high = std::min(high, lambda);
    const double first = s(0) + lambda;
    const double second = s(1) + lambda;
    const double slope =
        u(0) * u(0) / (first * first * first) + u(1) * u(1) / (second * second * second);
    double next = lambda + length * length * (length - 1.0) / slope;
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    if (std::abs(next - lambda) <= 1e-15 * scale) break;
    lambda = next;
  }
  r = Eigen::Vector2d(u(0) / (s(0) + lambda), u(1) / (s(1) + lambda));
  if (!r.allFinite() || !(r.norm() > 0.0)) return {{1.0, 0.0}, false};
  // S + lambda I is the Hessian on the plane; across r it must be more than nothing.
  const Eigen::Vector2d across(-r.y(), r.x());
  const double curvature =
      across.cwiseAbs2().dot(s + Eigen::Vector2d::Constant(lambda)) / r.squaredNorm();
  return {(eigen.eigenvectors() * r).normalized(), curvature > 1e-9 * scale};
}

}  // namespace

RigidAlignment<2> align_to_lines(std::span<const PointOnLine> pairs) {
  RigidAlignment<2> result;
  double total = 0.0;
  Eigen::Vector2d point_mean = Eigen::Vector2d::Zero();
  Eigen::Vector2d anchor_mean = Eigen::Vector2d::Zero();
  for (const PointOnLine& pair : pairs) {
    total += pair.weight;
    point_mean += pair.weight * pair.point;
    anchor_mean += pair.weight * pair.anchor;
  }
  if (!(total > 0.0)) return result;
  point_mean /= total;
  anchor_mean /= total;

  // Residual: a^T x - b with x = (t, cos, sin), a = (n, n^T p, n^T P p), P the quarter turn, b =
  // n^T q.
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  Eigen::Vector4d v = Eigen::Vector4d::Zero();
  for (const PointOnLine& pair : pairs) {
    const Eigen::Vector2d p = pair.point - point_mean;
    const Eigen::Vector2d& n = pair.normal;
    const Eigen::Vector4d a(n.x(), n.y(), n.dot(p), n.y() * p.x() - n.x() * p.y());
    m += pair.weight * a * a.transpose();
    v += pair.weight * n.dot(pair.anchor - anchor_mean) * a;
  }
  // The best translation for any rotation: t = A (v_t - B r), A the (pseudo-) inverse of the upper
  // left block.
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> upper;
  upper.computeDirect(Eigen::Matrix2d(m.topLeftCorner<2, 2>()));
  Eigen::Matrix2d inverse = Eigen::Matrix2d::Zero();
  bool translation_unique = true;
  for (int i = 0; i < 2; ++i) {
    const double value = upper.eigenvalues()(i);
    if (value > 1e-9 * upper.eigenvalues()(1)) {
      inverse += upper.eigenvectors().col(i) * upper.eigenvectors().col(i).transpose() / value;
    } else {
      translation_unique = false;
    }
  }
  const Eigen::Matrix2d mixed = m.topRightCorner<2, 2>();
  const UnitMinimiser best =
      minimise_on_circle(m.bottomRightCorner<2, 2>() - mixed.transpose() * inverse * mixed,
                         v.tail<2>() - mixed.transpose() * inverse * v.head<2>());
  const Eigen::Vector2d shift = inverse * (v.head<2>() - mixed * best.direction);
  result.rotation << best.direction.x(), -best.direction.y(),  //
      best.direction.y(), best.direction.x();
  result.translation = anchor_mean + shift - result.rotation * point_mean;
  result.unique = translation_unique && best.unique;
  return result;
}

}  // namespace loopstone
