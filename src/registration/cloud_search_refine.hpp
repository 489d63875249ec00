#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "loopstone/geometry/rigid_motion.hpp"
#include "loopstone/registration/distance_field.hpp"

namespace loopstone {

/// A pose in the model's principal frame, and the nearest model points there.
template <int kDimension>
struct Refined {
  using Motion = RigidMotion<kDimension>;

  typename Motion::Matrix rotation = Motion::Matrix::Identity();
  typename Motion::Vector translation = Motion::Vector::Zero();
  std::vector<std::int32_t>
      partners{};  ///< of each source point, its place among the field's points
  std::vector<double> squared_distances_m2{};
  double limit_m2 = 0.0;  ///< squared distance up to which pairs count
  double rmse_m = 0.0;    ///< over the pairs that count
  int iterations = 0;
  bool converged = false;
};

/// When a refinement ends.
struct RefineLimits {
  int max_iterations = 100;
  /// Two steps in a row that lower the rmse by less than this share.
  double progress_share = 1e-6;
};

/// Moves the source to the nearest minimum of sum_i |R p_i + t - nearest model point|^2 over the
/// closest `overlap` of the points, with exact nearest points.
///
/// Levenberg's scheme between two steps: Gauss-Newton on the distances (fast along the surface) and
/// that of iterated closest points, which never goes up. Both have the same gradient, so the
/// minimum is one of iterated closest points.
/// \param points  about their centroid, for steps are solved about the origin
/// Cost: O(iterations * points).
template <int kDimension>
[[nodiscard]] Refined<kDimension> refine(
    std::span<const Eigen::Matrix<double, kDimension, 1>> points,
    const DistanceField<kDimension>& model, double overlap,
    const typename RigidMotion<kDimension>::Matrix& rotation,
    const typename RigidMotion<kDimension>::Vector& translation, const RefineLimits& limits);

}  // namespace loopstone
