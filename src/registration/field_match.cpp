#include "loopstone/registration/field_match.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "loopstone/base/robust_kernel.hpp"
#include "loopstone/geometry/angle.hpp"
#include "registration/observability.hpp"

namespace loopstone {

namespace {

constexpr int kMinPairs = 10;
/// A step smaller than this share of a cell ends a level, as does a turn of so much.
constexpr double kStepShare = 0.002;
constexpr double kStepRad = 2e-5;
/// So does a cost that has not fallen by this share for some steps: the field has kinks where steps
/// go to and fro.
constexpr double kGainShare = 1e-3;
constexpr int kStalledSteps = 2;

/// A point that lies within reach of a wall.
struct Pair {
  Eigen::Vector2d arm;       // from the source's origin, target axes
  Eigen::Vector2d gradient;  // of the distance
  double distance_m;
  double weight;  // of the kernel

  /// Of the distance by (x, y, yaw).
  [[nodiscard]] Eigen::Vector3d jacobian() const {
    return {gradient.x(), gradient.y(), gradient.y() * arm.x() - gradient.x() * arm.y()};
  }
};

std::vector<Pair> pairs_at(std::span<const Eigen::Vector2d> source, const MapField& field,
                           std::size_t level, const Pose2& pose, double kernel_width_m) {
  std::vector<Pair> pairs;
  pairs.reserve(source.size());
  const Eigen::Matrix2d rotation = pose.rotation();
  const Eigen::Vector2d translation = pose.translation();
  const double reach = field.reach_m(level);
  for (const auto& point : source) {
    const Eigen::Vector2d arm = rotation * point;
    const FieldSample sample = field.sample(level, arm + translation);
    if (!(sample.distance_m < reach)) continue;
    const double weight =
        evaluate(RobustKernel::kCauchy, kernel_width_m, sample.distance_m * sample.distance_m)
            .weight;
    pairs.push_back({arm, sample.gradient, sample.distance_m, weight});
  }
  return pairs;
}

double cost_of(std::span<const Pair> pairs, std::size_t points, double kernel_width_m,
               double reach_m) {
  double cost = 0.0;
  for (const Pair& pair : pairs) {
    cost += evaluate(RobustKernel::kCauchy, kernel_width_m, pair.distance_m * pair.distance_m).cost;
  }
  // A point out of reach costs as much as one at the reach.
  return cost + static_cast<double>(points - pairs.size()) *
                    evaluate(RobustKernel::kCauchy, kernel_width_m, reach_m * reach_m).cost;
}

struct NormalEquations {
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

NormalEquations linearise(std::span<const Pair> pairs) {
  NormalEquations sum;
  for (const Pair& pair : pairs) {
    const Eigen::Vector3d jacobian = pair.jacobian();
    const Eigen::Vector3d weighted = pair.weight * jacobian;
    sum.hessian.noalias() += weighted * jacobian.transpose();
    sum.gradient += weighted * pair.distance_m;
  }
  return sum;
}

Observability<2> observability_at(std::span<const Pair> pairs, const Eigen::Matrix3d& hessian) {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (const Pair& pair : pairs) centre += pair.arm;
  centre /= static_cast<double>(pairs.size());
  double sum = 0.0;
  for (const Pair& pair : pairs) sum += (pair.arm - centre).squaredNorm();
  const double arm = std::sqrt(sum / static_cast<double>(pairs.size()));
  return observability_of<2>(hessian, centre, std::max(arm, 1e-3));
}

/// What the points on one face add up to.
struct Face {
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  double distance = 0.0;  ///< weighted sum
  double weight = 0.0;

  /// How far the face lies off what the pose makes of it, squared.
  [[nodiscard]] double offset2() const {
    const double offset = distance / std::max(weight, 1e-9);
    return offset * offset;
  }
};

/// What the errors of the points and of the walls add up to in the gradient. A face is rounded to
/// cells, so all points on it share one error of variance resolution^2 / 12, and one by which the
/// face contradicts the others (a cluster-robust covariance: Liang and Zeger 1986). Points share a
/// face when it looks the same way and lies as far along that way; a slanted wall falls into
/// several pieces, as its rounding changes along it.
Eigen::Matrix3d noise_of(std::span<const Pair> pairs, const Eigen::Vector2d& translation,
                         double sigma_m, double resolution_m) {
  constexpr double kEighth = kPi / 4.0;
  constexpr double kSameFaceM = 0.25;
  Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();
  std::map<std::pair<int, int>, Face> faces;
  for (const Pair& pair : pairs) {
    const Eigen::Vector3d jacobian = pair.weight * pair.jacobian();
    noise.noalias() += sigma_m * sigma_m * jacobian * jacobian.transpose();
    // Either side of a face pulls it the same way: count the gradient with the sign that points to
    // the upper half plane.
    double sign = 1.0;
    const Eigen::Vector2d& g = pair.gradient;
    if (g.y() < -1e-9 || (std::abs(g.y()) <= 1e-9 && g.x() < 0.0)) sign = -1.0;
    int way = static_cast<int>(std::lround(std::atan2(sign * g.y(), sign * g.x()) / kEighth));
    if (way == 4) {
      way = 0;
      sign = -sign;
    }
    const Eigen::Vector2d normal(std::cos(way * kEighth), std::sin(way * kEighth));
    const int offset =
        static_cast<int>(std::lround(normal.dot(pair.arm + translation) / kSameFaceM));
    Face& face = faces[{way, offset}];
    face.gradient += sign * jacobian;
    face.distance += sign * pair.weight * pair.distance_m;
    face.weight += pair.weight;
  }
  const double rounding = resolution_m * resolution_m / 12.0;
  for (const auto& [key, face] : faces)
    noise.noalias() += (rounding + face.offset2()) * face.gradient * face.gradient.transpose();
  return noise;
}

/// Where the descent stands.
struct Descent {
  Pose2 pose;
  int iterations = 0;
  bool converged = false;
};

/// Gauss-Newton on one level, to the best pose that it comes by.
void descend(Descent& at, std::span<const Eigen::Vector2d> source, const MapField& field,
             std::size_t level, const FieldMatchOptions& options) {
  const double width = options.kernel_width_m * static_cast<double>(1U << level);
  at.converged = false;
  Pose2 best = at.pose;
  double best_cost = std::numeric_limits<double>::infinity();
  int stalled = 0;
  for (int iteration = 0; iteration < options.max_iterations && !at.converged; ++iteration) {
    const std::vector<Pair> pairs = pairs_at(source, field, level, at.pose, width);
    ++at.iterations;
    if (pairs.size() < kMinPairs) break;
    const double cost = cost_of(pairs, source.size(), width, field.reach_m(level));
    stalled = cost < (1.0 - kGainShare) * best_cost ? 0 : stalled + 1;
    if (cost < best_cost) {
      best_cost = cost;
      best = at.pose;
    }
    if (stalled == kStalledSteps) {
      at.converged = true;
      break;
    }
    const NormalEquations sum = linearise(pairs);
    const Eigen::Vector3d step = observability_at(pairs, sum.hessian).solve(sum.gradient);
    if (!step.allFinite()) break;
    at.pose = RigidMotion<2>::moved(at.pose, step);
    at.converged = step.head<2>().norm() < kStepShare * field.resolution_m(level) &&
                   std::abs(step.z()) < kStepRad;
  }
  at.pose = best;
}

/// How well the pose fits.
MatchResult judged(const Descent& descent, std::span<const Eigen::Vector2d> source,
                   std::vector<Pair> pairs, const MapField& field,
                   const FieldMatchOptions& options) {
  double squares = 0.0;
  double weights = 0.0;
  int explained = 0;
  for (const Pair& pair : pairs) {
    squares += pair.weight * pair.distance_m * pair.distance_m;
    weights += pair.weight;
    if (pair.distance_m < 2.0 * options.kernel_width_m) ++explained;
  }
  const auto count = static_cast<double>(source.size());
  MatchResult result{.target_T_source = descent.pose, .iterations = descent.iterations};
  result.rmse_m = std::sqrt(squares / weights);
  result.pairs = static_cast<int>(pairs.size());
  result.inlier_fraction = static_cast<double>(pairs.size()) / count;
  result.score = explained / count;
  // What holds a pose are walls, not the steps of their cells.
  for (Pair& pair : pairs) {
    pair.gradient =
        field.wall_normal(pair.arm + descent.pose.translation(), {pair.distance_m, pair.gradient});
  }
  const auto observability = observability_at(pairs, linearise(pairs).hessian);
  const double sigma = std::max(options.point_sigma_m, result.rmse_m);
  result.covariance = observability.covariance(
      noise_of(pairs, descent.pose.translation(), sigma, field.resolution_m(0)));
  if (!observability.complete()) {
    result.status = MatchStatus::kDegenerate;
  } else {
    result.status = descent.converged ? MatchStatus::kConverged : MatchStatus::kNotConverged;
  }
  return result;
}

}  // namespace

MatchResult match_to_field(std::span<const Eigen::Vector2d> source, const MapField& field,
                           const Pose2& guess, const FieldMatchOptions& options,
                           std::size_t coarsest_level) {
  Descent descent{.pose = guess};
  for (std::size_t above = std::min(coarsest_level, field.level_count() - 1) + 1; above > 0;
       --above) {
    descend(descent, source, field, above - 1, options);
  }
  std::vector<Pair> pairs = pairs_at(source, field, 0, descent.pose, options.kernel_width_m);
  if (pairs.size() < kMinPairs) {
    return {.target_T_source = guess,
            .iterations = descent.iterations,
            .status = MatchStatus::kTooFewPairs};
  }
  return judged(descent, source, std::move(pairs), field, options);
}

FieldCost field_cost(std::span<const Eigen::Vector2d> source, const MapField& field,
                     std::size_t level, const Pose2& target_T_source, double kernel_width_m) {
  FieldCost result;
  const auto pairs = pairs_at(source, field, level, target_T_source, kernel_width_m);
  result.cost = cost_of(pairs, source.size(), kernel_width_m, field.reach_m(level));
  result.gradient = 2.0 * linearise(pairs).gradient;
  return result;
}

}  // namespace loopstone
