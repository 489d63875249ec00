#include "registration/icp_judge.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "loopstone/base/median.hpp"
#include "registration/icp_step.hpp"

namespace loopstone {

namespace {

/// Residuals smaller than this share of a point's standard deviation are not believed.
constexpr double kLeastSigmaShare = 0.05;

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
        to_anchor_(pair.arm + translation - patch.anchor) {}

  /// Distance across the surface; per axis where there is none.
  [[nodiscard]] double residual_m() const {
    return patch.flat ? patch.normal.dot(to_anchor_)
                      : to_point.norm() / std::sqrt(static_cast<double>(kDimension));
  }
  [[nodiscard]] bool explained(double sigma_m) const {
    const double distance_m = to_point.norm();
    if (!patch.flat) return distance_m <= 3.0 * sigma_m;
    return std::abs(patch.normal.dot(to_anchor_)) <= 3.0 * sigma_m &&
           distance_m <= patch.radius_m + 3.0 * sigma_m;
  }

 private:
  Vector to_anchor_;
};

struct Noise {
  double source_sigma_m = 0.0;
  double target_sigma_m = 0.0;
};

/// The residual across a patch that averages k points has the variance s_p^2 + s_q^2 / k; s_q shows
/// in the patch's thickness.
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

/// What the target's surfaces make of the pairs, P_i = n n^T on a surface, 1 where there is none.
template <int kDimension>
struct SurfaceInformation {
  using Matrix = typename Observability<kDimension>::Matrix;

  IcpEquations<kDimension> equations{};  ///< information: sum_i w_i J_i^T P_i J_i; no gradient
  Matrix source_noise = Matrix::Zero();  ///< sum_i w_i^2 J_i^T P_i J_i
  /// sum over target points j of G_j G_j^T, G_j the sum of w_i J_i^T P_i over the pairs of j: noise
  /// of a target point moves all its pairs alike.
  Matrix target_noise = Matrix::Zero();
};

/// Edges and corners are no surfaces; taken for landmarks, the edges of a corridor would hold its
/// axis. So points without a surface count only when most are such.
template <int kDimension>
bool surfaces_alone(std::span<const IcpPair<kDimension>> pairs,
                    const IcpCloud<kDimension>& target) {
  const auto flat = std::count_if(pairs.begin(), pairs.end(), [&](const auto& pair) {
    return target.patches[static_cast<std::size_t>(pair.target)].flat;
  });
  return 2 * static_cast<std::size_t>(flat) >= pairs.size();
}

template <int kDimension>
SurfaceInformation<kDimension> surface_information(std::span<const IcpPair<kDimension>> pairs,
                                                   const IcpCloud<kDimension>& target) {
  using Motion = RigidMotion<kDimension>;
  using Tangent = typename Motion::Tangent;
  using Rows = Eigen::Matrix<double, Motion::kDof, kDimension>;
  SurfaceInformation<kDimension> result;
  const bool alone = surfaces_alone(pairs, target);
  std::vector<std::int32_t> slot(target.points().size(), -1);
  std::vector<Rows> sums;
  sums.reserve(pairs.size());
  for (const auto& pair : pairs) {
    const auto j = static_cast<std::size_t>(pair.target);
    const SurfacePatch<kDimension>& patch = target.patches[j];
    if (pair.weight <= 0.0 || (alone && !patch.flat)) continue;
    Rows rows = Motion::point_jacobian(pair.arm).transpose();
    if (patch.flat) {
      const Tangent across = rows * patch.normal;
      rows.noalias() = across * patch.normal.transpose();
      const Tangent weighted = pair.weight * across;
      result.equations.information.noalias() += weighted * across.transpose();
      result.source_noise.noalias() += weighted * weighted.transpose();
    } else {
      result.equations.information.noalias() += pair.weight * (rows * rows.transpose());
      result.source_noise.noalias() += (pair.weight * pair.weight) * (rows * rows.transpose());
    }
    if (slot[j] < 0) {
      slot[j] = static_cast<std::int32_t>(sums.size());
      sums.push_back(pair.weight * rows);
    } else {
      sums[static_cast<std::size_t>(slot[j])] += pair.weight * rows;
    }
  }
  for (const Rows& rows : sums) result.target_noise.noalias() += rows * rows.transpose();
  set_extent(result.equations, pairs);
  return result;
}

}  // namespace

template <int kDimension>
Observability<kDimension> surface_observability(std::span<const IcpPair<kDimension>> pairs,
                                                const IcpCloud<kDimension>& target) {
  return surface_information<kDimension>(pairs, target).equations.observability();
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
  const SurfaceInformation<kDimension> surfaces = surface_information<kDimension>(pairs, target);
  const Observability<kDimension> observability = surfaces.equations.observability();
  result.covariance =
      observability.covariance(noise.source_sigma_m * noise.source_sigma_m * surfaces.source_noise +
                               noise.target_sigma_m * noise.target_sigma_m * surfaces.target_noise);
  if (result.status == MatchStatus::kConverged && !observability.complete()) {
    result.status = MatchStatus::kDegenerate;
  }
  if (share(explained, overlapping) < options.least_explained) {
    result.status = MatchStatus::kNotConverged;
  }
}

template Observability<2> surface_observability<2>(std::span<const IcpPair<2>>, const IcpCloud<2>&);
template Observability<3> surface_observability<3>(std::span<const IcpPair<3>>, const IcpCloud<3>&);
template void judge<2>(MatchResult&, std::span<const IcpPair<2>>, const IcpCloud<2>&, IcpMetric,
                       std::size_t, std::size_t, const IcpOptions&);
template void judge<3>(MatchResult3&, std::span<const IcpPair<3>>, const IcpCloud<3>&, IcpMetric,
                       std::size_t, std::size_t, const IcpOptions&);

}  // namespace loopstone
