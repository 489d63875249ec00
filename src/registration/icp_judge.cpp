#include "registration/icp_judge.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "registration/icp_step.hpp"

namespace loopstone {

namespace {

/// Residuals smaller than this share of a point's standard deviation are not believed.
constexpr double kLeastSigmaShare = 0.05;
/// Standard deviation = this times the median of the absolute values, for normal noise.
constexpr double kSigmaPerMedian = 1.4826;

double median_of(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The pair as the target's patch sees it.
template <int kDimension>
struct OnPatch {
  using Vector = typename RigidMotion<kDimension>::Vector;

  const SurfacePatch<kDimension>& patch;
  Vector to_point;  ///< from the target point

  OnPatch(const IcpPair<kDimension>& pair, const IcpCloud<kDimension>& target,
          const Vector& translation)
      : patch(target.patches[static_cast<std::size_t>(pair.target)]),
        to_point(pair.arm + translation - target.points()[static_cast<std::size_t>(pair.target)]),
        to_anchor(pair.arm + translation - patch.anchor) {}

  /// Distance across the surface; per axis where there is none.
  [[nodiscard]] double residual_m() const {
    return patch.flat ? patch.normal.dot(to_anchor)
                      : to_point.norm() / std::sqrt(static_cast<double>(kDimension));
  }
  [[nodiscard]] bool explained(double sigma_m) const {
    const double distance_m = to_point.norm();
    if (!patch.flat) return distance_m <= 3.0 * sigma_m;
    return std::abs(patch.normal.dot(to_anchor)) <= 3.0 * sigma_m &&
           distance_m <= patch.radius_m + 3.0 * sigma_m;
  }

 private:
  Vector to_anchor;
};

struct Noise {
  double source_sigma_m = 0.0;
  double target_sigma_m = 0.0;
};

/// The residual across a patch that averages k points has the variance s_p^2 + s_q^2 / k; s_q shows in the patch's
/// thickness.
template <int kDimension>
Noise noise_of(std::span<const IcpPair<kDimension>> pairs, const IcpCloud<kDimension>& target,
               const typename RigidMotion<kDimension>::Vector& translation, IcpMetric metric,
               double least_sigma_m) {
  constexpr int kDof = RigidMotion<kDimension>::kDof;
  std::vector<double> residuals;
  std::vector<double> thicknesses;
  residuals.reserve(pairs.size());
  thicknesses.reserve(pairs.size());
  double averaged = 0.0;
  for (const auto& pair : pairs) {
    const OnPatch<kDimension> on_patch(pair, target, translation);
    // Point to point also pays for how far apart the points of a surface lie.
    residuals.push_back(metric == IcpMetric::kPoint
                            ? on_patch.to_point.norm() / std::sqrt(static_cast<double>(kDimension))
                            : std::abs(on_patch.residual_m()));
    if (on_patch.patch.flat) thicknesses.push_back(on_patch.patch.thickness_m);
    averaged += on_patch.patch.points;
  }
  const auto count = static_cast<double>(pairs.size());
  const double freedom = std::sqrt(count / std::max(count - kDof, 1.0));
  Noise noise;
  noise.source_sigma_m = std::max(kSigmaPerMedian * median_of(residuals) * freedom, least_sigma_m);
  noise.target_sigma_m =
      thicknesses.empty() ? noise.source_sigma_m : std::max(median_of(thicknesses), least_sigma_m);
  return noise;
}

/// sum over target points j of G_j G_j^T, G_j = sum of w_i J_i^T P_i over the pairs of j, P_i = n n^T or 1: how noise of the
/// target points, each shared by all pairs of the point, moves the gradient.
template <int kDimension>
typename Observability<kDimension>::Matrix shared_information(
    std::span<const IcpPair<kDimension>> pairs, const IcpCloud<kDimension>& target) {
  using Motion = RigidMotion<kDimension>;
  using Rows = Eigen::Matrix<double, Motion::kDof, kDimension>;
  std::vector<std::int32_t> slot(target.points().size(), -1);
  std::vector<Rows> sums;
  sums.reserve(pairs.size());
  for (const auto& pair : pairs) {
    if (pair.weight <= 0.0) continue;
    const auto j = static_cast<std::size_t>(pair.target);
    const SurfacePatch<kDimension>& patch = target.patches[j];
    Rows rows = Motion::point_jacobian(pair.arm).transpose();
    if (patch.flat) rows = ((rows * patch.normal) * patch.normal.transpose()).eval();
    if (slot[j] < 0) {
      slot[j] = static_cast<std::int32_t>(sums.size());
      sums.push_back(pair.weight * rows);
    } else {
      sums[static_cast<std::size_t>(slot[j])] += pair.weight * rows;
    }
  }
  typename Observability<kDimension>::Matrix result;
  result.setZero();
  for (const Rows& rows : sums) result.noalias() += rows * rows.transpose();
  return result;
}

/// sum_i w_i^power J_i^T P_i J_i.
template <int kDimension>
IcpEquations<kDimension> surface_equations(std::span<const IcpPair<kDimension>> pairs,
                                           const IcpCloud<kDimension>& target, bool squared) {
  std::vector<IcpPair<kDimension>> on_surfaces;
  std::vector<IcpPair<kDimension>> at_points;
  for (const auto& pair : pairs) {
    const SurfacePatch<kDimension>& patch = target.patches[static_cast<std::size_t>(pair.target)];
    auto& list = patch.flat ? on_surfaces : at_points;
    list.push_back(pair);
    list.back().normal = patch.normal;
    if (squared) list.back().weight *= pair.weight;
  }
  IcpEquations<kDimension> result = equations_of<kDimension>(
      std::span<const IcpPair<kDimension>>(on_surfaces), IcpMetric::kPlane);
  const IcpEquations<kDimension> points =
      equations_of<kDimension>(std::span<const IcpPair<kDimension>>(at_points), IcpMetric::kPoint);
  const IcpEquations<kDimension> all = equations_of<kDimension>(pairs, IcpMetric::kPoint);
  result.information += points.information;
  result.centre = all.centre;
  result.arm_m = all.arm_m;
  return result;
}

}  // namespace

template <int kDimension>
Observability<kDimension> surface_observability(std::span<const IcpPair<kDimension>> pairs,
                                                const IcpCloud<kDimension>& target,
                                                const typename RigidMotion<kDimension>::Vector&) {
  return surface_equations<kDimension>(pairs, target, false).observability();
}

template <int kDimension>
void judge(BasicMatchResult<kDimension>& result, std::span<const IcpPair<kDimension>> pairs,
           const IcpCloud<kDimension>& target, IcpMetric metric, std::size_t overlapping,
           std::size_t source_size, const IcpOptions& options) {
  const auto translation = RigidMotion<kDimension>::translation(result.target_T_source);
  double squared_sum = 0.0;
  double weight_sum = 0.0;
  std::size_t explained = 0;
  for (const auto& pair : pairs) {
    squared_sum += pair.weight * pair.squared_residual_m2;
    weight_sum += pair.weight;
    if (OnPatch<kDimension>(pair, target, translation).explained(options.point_sigma_m)) {
      ++explained;
    }
  }
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
  };
  result.pairs = static_cast<int>(pairs.size());
  result.rmse_m = weight_sum > 0.0 ? std::sqrt(squared_sum / weight_sum) : 0.0;
  result.inlier_fraction = share(pairs.size(), source_size);
  result.score = share(explained, source_size);

  const Noise noise = noise_of<kDimension>(pairs, target, translation, metric,
                                           kLeastSigmaShare * options.point_sigma_m);
  const Observability<kDimension> observability =
      surface_equations<kDimension>(pairs, target, false).observability();
  result.covariance = observability.covariance(
      noise.source_sigma_m * noise.source_sigma_m *
          surface_equations<kDimension>(pairs, target, true).information +
      noise.target_sigma_m * noise.target_sigma_m * shared_information<kDimension>(pairs, target));
  if (result.status == MatchStatus::kConverged && !observability.complete()) {
    result.status = MatchStatus::kDegenerate;
  }
  if (share(explained, overlapping) < options.least_explained) {
    result.status = MatchStatus::kNotConverged;
  }
}

template Observability<2> surface_observability<2>(std::span<const IcpPair<2>>, const IcpCloud<2>&,
                                                   const Eigen::Vector2d&);
template Observability<3> surface_observability<3>(std::span<const IcpPair<3>>, const IcpCloud<3>&,
                                                   const Eigen::Vector3d&);
template void judge<2>(MatchResult&, std::span<const IcpPair<2>>, const IcpCloud<2>&, IcpMetric,
                       std::size_t, std::size_t, const IcpOptions&);
template void judge<3>(MatchResult3&, std::span<const IcpPair<3>>, const IcpCloud<3>&, IcpMetric,
                       std::size_t, std::size_t, const IcpOptions&);

}  // namespace loopstone
