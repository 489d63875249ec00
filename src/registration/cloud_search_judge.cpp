#include "registration/cloud_search_judge.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "registration/observability.hpp"

namespace loopstone {

namespace {

/// Of the model's radius: source points within it are explained.
constexpr double kExplainedShare = 1.0 / 14.0;
/// So many source points tell which way the surface faces.
constexpr std::size_t kNormals = 400;
/// A direction with less than this share of the best one's information is unobserved. Less than
/// what a single match asks for: shapes whose symmetry is not broken at all show as rivals.
constexpr double kObservedShare = 1e-3;

/// What the pairs say about the pose, and how noisy that is.
template <int kDimension>
struct Evidence {
  using Motion = RigidMotion<kDimension>;
  using Information = Eigen::Matrix<double, Motion::kDof, Motion::kDof>;

  Information information = Information::Zero();  ///< sum J^T n n^T J
  Information noise = Information::Zero();        ///< sum over model points of g g^T, g = sum J^T r
  typename Motion::Vector centre = Motion::Vector::Zero();  ///< of the arms
  double arm_m = 1.0;
};

template <int kDimension>
Evidence<kDimension> evidence_of(std::span<const Eigen::Matrix<double, kDimension, 1>> source,
                                 const typename RigidMotion<kDimension>::Pose& target_T_source,
                                 const Refined<kDimension>& refined,
                                 const CloudModel<kDimension>& model) {
  using Motion = RigidMotion<kDimension>;
  Evidence<kDimension> evidence;
  const typename Motion::Matrix rotation = Motion::rotation(target_T_source);
  const typename Motion::Matrix from_frame = model.frame().rotation.transpose();
  const auto place_of = [&](std::int32_t partner) -> typename Motion::Vector {
    return from_frame *
               model.field().points()[static_cast<std::size_t>(partner)].template cast<double>() +
           model.frame().centre;
  };
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < source.size(); ++i) {
    if (refined.squared_distances_m2[i] <= refined.limit_m2) used.push_back(i);
  }
  const auto total = static_cast<double>(used.size());

  std::vector<typename Motion::Tangent> pulls(model.field().points().size(),
                                              Motion::Tangent::Zero());
  for (const std::size_t i : used) {
    const typename Motion::Vector arm = rotation * source[i];
    const std::int32_t partner = refined.partners[i];
    pulls[static_cast<std::size_t>(partner)] +=
        Motion::point_jacobian(arm).transpose() *
        (arm + Motion::translation(target_T_source) - place_of(partner));
    evidence.centre += arm / total;
  }
  for (const auto& pull : pulls) {
    if (!pull.isZero(0.0)) evidence.noise.noalias() += pull * pull.transpose();
  }
  double squared_arms = 0.0;
  for (const std::size_t i : used) {
    squared_arms += (rotation * source[i] - evidence.centre).squaredNorm() / total;
  }
  if (squared_arms > 0.0) evidence.arm_m = std::sqrt(squared_arms);

  const std::size_t stride = (used.size() + kNormals - 1) / kNormals;
  double counted = 0.0;
  for (std::size_t k = 0; k < used.size(); k += stride) {
    const auto& place = model.field().points()[static_cast<std::size_t>(refined.partners[used[k]])];
    const typename Motion::Vector normal =
        from_frame * model.field().normal_near(place).template cast<double>();
    const typename Motion::Tangent row =
        Motion::point_jacobian(rotation * source[used[k]]).transpose() * normal;
    evidence.information.noalias() += row * row.transpose();
    counted += 1.0;
  }
  evidence.information *= total / counted;
  return evidence;
}

}  // namespace

template <int kDimension>
BasicMatchResult<kDimension> nothing_to_align() {
  BasicMatchResult<kDimension> match;
  match.status = MatchStatus::kTooFewPairs;
  return match;
}

template <int kDimension>
BasicMatchResult<kDimension> judge(std::span<const Eigen::Matrix<double, kDimension, 1>> source,
                                   const typename RigidMotion<kDimension>::Pose& target_T_source,
                                   const Refined<kDimension>& refined,
                                   const CloudModel<kDimension>& model, double least_explained) {
  BasicMatchResult<kDimension> match;
  match.target_T_source = target_T_source;
  match.rmse_m = refined.rmse_m;
  match.iterations = refined.iterations;
  const double near_m = kExplainedShare * model.frame().radius_m;
  int explained = 0;
  for (const double squared : refined.squared_distances_m2) {
    if (squared <= near_m * near_m) ++explained;
    if (squared <= refined.limit_m2) ++match.pairs;
  }
  match.score = explained / static_cast<double>(source.size());
  match.inlier_fraction = match.pairs / static_cast<double>(source.size());

  const auto evidence = evidence_of<kDimension>(source, target_T_source, refined, model);
  auto observability =
      observability_of<kDimension>(evidence.information, evidence.centre, evidence.arm_m);
  observability.observed =
      observability.information.array() >
      kObservedShare * observability.information(RigidMotion<kDimension>::kDof - 1);
  match.covariance = observability.covariance(evidence.noise);
  if (!refined.converged || match.score < least_explained) {
    match.status = MatchStatus::kNotConverged;
  } else {
    match.status = observability.complete() ? MatchStatus::kConverged : MatchStatus::kDegenerate;
  }
  return match;
}

template <int kDimension>
BasicMatchResult<kDimension> with_rival(BasicMatchResult<kDimension> match,
                                        const typename RigidMotion<kDimension>::Pose& rival) {
  const auto apart = RigidMotion<kDimension>::difference(rival, match.target_T_source);
  match.covariance += 0.5 * apart * apart.transpose();
  if (match.status == MatchStatus::kConverged) match.status = MatchStatus::kDegenerate;
  return match;
}

template BasicMatchResult<2> nothing_to_align<2>();
template BasicMatchResult<3> nothing_to_align<3>();
template BasicMatchResult<2> judge<2>(std::span<const Eigen::Vector2d>, const Pose2&,
                                      const Refined<2>&, const CloudModel<2>&, double);
template BasicMatchResult<3> judge<3>(std::span<const Eigen::Vector3d>, const Pose3&,
                                      const Refined<3>&, const CloudModel<3>&, double);
template BasicMatchResult<2> with_rival<2>(BasicMatchResult<2>, const Pose2&);
template BasicMatchResult<3> with_rival<3>(BasicMatchResult<3>, const Pose3&);

}  // namespace loopstone
