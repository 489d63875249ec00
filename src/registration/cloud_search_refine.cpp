#include "registration/cloud_search_refine.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/symmetric_matrix.hpp"

namespace loopstone {

namespace {

/// How much motion across a residual counts in the Hessian, beside motion along it: 1 is a step of
/// iterated closest points.
constexpr double kLeastAcross = 0.1;
constexpr double kMoreAcross = 4.0;
constexpr double kLessAcross = 0.5;
constexpr int kSlowSteps = 2;

/// J^T r for a residual and the arm from the source's origin to its point.
Eigen::Vector3d pull(const Eigen::Vector2d& r, const Eigen::Vector2d& arm) {
  return {r.x(), r.y(), arm.x() * r.y() - arm.y() * r.x()};
}
Eigen::Matrix<double, 6, 1> pull(const Eigen::Vector3d& r, const Eigen::Vector3d& arm) {
  return {r.x(),
          r.y(),
          r.z(),
          arm.y() * r.z() - arm.z() * r.y(),
          arm.z() * r.x() - arm.x() * r.z(),
          arm.x() * r.y() - arm.y() * r.x()};
}

template <int kDimension>
struct Refinement {
  using Motion = RigidMotion<kDimension>;
  using Vector = typename Motion::Vector;
  using Matrix = typename Motion::Matrix;
  using Tangent = typename Motion::Tangent;
  using Information = Eigen::Matrix<double, Motion::kDof, Motion::kDof>;

  struct Normal {
    Information along = Information::Zero();  ///< sum J^T n n^T J, n = r / |r|
    Information all = Information::Zero();    ///< sum J^T J
    Tangent gradient = Tangent::Zero();       ///< sum J^T r
  };

  std::span<const Vector> points;
  const DistanceField<kDimension>& model;
  std::size_t kept;
  std::vector<double> distances{};  ///< scratch

  /// Fills in pairs, limit and rmse of the pose. The partners it comes with serve as hints.
  void pair_up(Refined<kDimension>& pose) {
    pose.partners.resize(points.size(), -1);
    pose.squared_distances_m2.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector moved = pose.rotation * points[i] + pose.translation;
      const auto nearest = model.nearest_point(moved.template cast<float>(), pose.partners[i]);
      pose.partners[i] = nearest.point;
      pose.squared_distances_m2[i] = (moved - partner_of(pose, i)).squaredNorm();
    }
    pose.limit_m2 = std::numeric_limits<double>::infinity();
    if (kept < points.size()) {
      distances = pose.squared_distances_m2;
      const auto limit = distances.begin() + static_cast<std::ptrdiff_t>(kept - 1);
      std::nth_element(distances.begin(), limit, distances.end());
      pose.limit_m2 = *limit;
    }
    double sum = 0.0;
    std::size_t used = 0;
    for (const double squared : pose.squared_distances_m2) {
      if (squared > pose.limit_m2) continue;
      sum += squared;
      ++used;
    }
    pose.rmse_m = std::sqrt(sum / static_cast<double>(used));
  }

  [[nodiscard]] Vector partner_of(const Refined<kDimension>& pose, std::size_t i) const {
    return model.points()[static_cast<std::size_t>(pose.partners[i])].template cast<double>();
  }

  [[nodiscard]] Normal linearise(const Refined<kDimension>& pose) const {
    Normal sums;
    double count = 0.0;
    Vector arm_sum = Vector::Zero();
    Matrix arm_squares = Matrix::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double squared = pose.squared_distances_m2[i];
      if (squared > pose.limit_m2) continue;
      const Vector arm = pose.rotation * points[i];
      const Tangent gradient = pull(arm + pose.translation - partner_of(pose, i), arm);
      sums.gradient += gradient;
      count += 1.0;
      arm_sum += arm;
      for (int a = 0; a < kDimension; ++a) {
        for (int b = a; b < kDimension; ++b) arm_squares(a, b) += arm(a) * arm(b);
      }
      if (!(squared > 0.0)) continue;
      const double inverse = 1.0 / squared;
      for (int a = 0; a < Motion::kDof; ++a) {
        const double scaled = gradient(a) * inverse;
        for (int b = a; b < Motion::kDof; ++b) sums.along(a, b) += scaled * gradient(b);
      }
    }
    sums.along = Information(sums.along.template selfadjointView<Eigen::Upper>());
    arm_squares = Matrix(arm_squares.template selfadjointView<Eigen::Upper>());
    // sum J^T J with J = [I, d(turn x arm) / d turn].
    constexpr int kTurns = Motion::kDof - kDimension;
    const Eigen::Matrix<double, kDimension, kTurns> sum_of_turns =
        Motion::point_jacobian(arm_sum).template rightCols<kTurns>();
    sums.all.template topLeftCorner<kDimension, kDimension>() = count * Matrix::Identity();
    sums.all.template topRightCorner<kDimension, kTurns>() = sum_of_turns;
    sums.all.template bottomLeftCorner<kTurns, kDimension>() = sum_of_turns.transpose();
    sums.all.template bottomRightCorner<kTurns, kTurns>() =
        arm_squares.trace() * Eigen::Matrix<double, kTurns, kTurns>::Identity();
    if constexpr (kDimension == 3) {
      sums.all.template bottomRightCorner<3, 3>() -= arm_squares;
    }
    return sums;
  }

  [[nodiscard]] static Refined<kDimension> moved(const Refined<kDimension>& pose,
                                                 const Normal& sums, double across) {
    Information hessian = (1.0 - across) * sums.along + across * sums.all;
    hessian.diagonal() *= 1.0 + 1e-9;
    const Tangent step = -solve_symmetric(hessian, sums.gradient);
    Refined<kDimension> next = pose;
    ++next.iterations;
    if (!step.allFinite()) return next;
    const auto turned = Motion::moved(Motion::pose(pose.rotation, pose.translation), step);
    next.rotation = Motion::rotation(turned);
    next.translation = Motion::translation(turned);
    return next;
  }
};

}  // namespace

template <int kDimension>
Refined<kDimension> refine(std::span<const Eigen::Matrix<double, kDimension, 1>> points,
                           const DistanceField<kDimension>& model, double overlap,
                           const typename RigidMotion<kDimension>::Matrix& rotation,
                           const typename RigidMotion<kDimension>::Vector& translation,
                           const RefineLimits& limits) {
  Refinement<kDimension> work{
      points, model,
      std::clamp<std::size_t>(
          static_cast<std::size_t>(std::ceil(overlap * static_cast<double>(points.size()))), 1,
          points.size())};
  Refined<kDimension> pose;
  pose.rotation = rotation;
  pose.translation = translation;
  work.pair_up(pose);
  auto sums = work.linearise(pose);
  double across = kLeastAcross;
  int slow_steps = 0;
  while (pose.iterations < limits.max_iterations && !pose.converged) {
    Refined<kDimension> next = work.moved(pose, sums, across);
    work.pair_up(next);
    const double gain = pose.rmse_m - next.rmse_m;
    if (!(gain > 0.0)) {
      // When not even the step that never goes up goes down, this is a minimum.
      pose.converged = across >= 1.0 || pose.rmse_m == 0.0;
      pose.iterations = next.iterations;
      across = std::min(1.0, kMoreAcross * across);
      continue;
    }
    slow_steps = gain < limits.progress_share * pose.rmse_m ? slow_steps + 1 : 0;
    pose = std::move(next);
    pose.converged = slow_steps >= kSlowSteps;
    across = std::max(kLeastAcross, kLessAcross * across);
    if (!pose.converged) sums = work.linearise(pose);
  }
  return pose;
}

template Refined<2> refine<2>(std::span<const Eigen::Vector2d>, const DistanceField<2>&, double,
                              const Eigen::Matrix2d&, const Eigen::Vector2d&, const RefineLimits&);
template Refined<3> refine<3>(std::span<const Eigen::Vector3d>, const DistanceField<3>&, double,
                              const Eigen::Matrix3d&, const Eigen::Vector3d&, const RefineLimits&);

}  // namespace loopstone
