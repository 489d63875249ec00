#include "loopstone/registration/icp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/geometry/rigid_alignment.hpp"
#include "registration/observability.hpp"

namespace loopstone {

namespace {

constexpr std::size_t kMinPairs = 3;
constexpr std::size_t kNormalNeighbours = 7;
constexpr double kNormalRadiusM = 0.6;
constexpr double kLeastArmM = 1e-3;
/// Pairs may change to and fro for ever. When the residuals have not shrunk by this share for so many steps, that is it.
constexpr double kProgressShare = 0.002;
constexpr int kPatientSteps = 5;

enum class Metric { kPoint, kLine };

Metric metric_from(const std::string& name) {
  if (name == "point") return Metric::kPoint;
  if (name == "line") return Metric::kLine;
  throw UsageError("metric: '" + name + "' is neither point nor line");
}

/// A source point and the target point it belongs to.
struct Pair {
  Eigen::Vector2d source;  ///< source frame
  Eigen::Vector2d arm;     ///< from the source frame's origin to the point, target axes
  Eigen::Vector2d offset;  ///< from the target point to the source point, target frame
  std::optional<Eigen::Vector2d> normal;
  double distance_m = 0.0;
  double weight = 1.0;

  [[nodiscard]] double residual(Metric metric) const {
    return metric == Metric::kLine && normal ? normal->dot(offset) : distance_m;
  }
};

std::vector<Pair> find_pairs(std::span<const Eigen::Vector2d> source, const IcpTarget& target,
                             const Pose2& target_T_source, Metric metric,
                             const IcpOptions& options) {
  std::vector<Pair> pairs;
  pairs.reserve(source.size());
  const Eigen::Matrix2d rotation = target_T_source.rotation();
  for (const Eigen::Vector2d& point : source) {
    const Eigen::Vector2d arm = rotation * point;
    const Eigen::Vector2d moved = arm + target_T_source.translation();
    const auto found = target.index.nearest(moved, options.max_pair_distance_m);
    if (!found) continue;
    const auto& normal = target.normals[found->index];
    if (metric == Metric::kLine && !normal) continue;
    pairs.push_back(
        {point, arm, moved - target.index.points()[found->index], normal, found->distance_m, 1.0});
  }
  const auto kept = static_cast<std::size_t>(
      std::ceil(options.trim_fraction * static_cast<double>(pairs.size())));
  if (kept < pairs.size()) {
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const Pair& a, const Pair& b) { return a.distance_m < b.distance_m; });
    pairs.resize(kept);
  }
  if (options.kernel_width_m > 0.0) {
    for (Pair& pair : pairs) {
      const double ratio = pair.residual(metric) / options.kernel_width_m;
      pair.weight = 1.0 / (1.0 + ratio * ratio);
    }
  }
  return pairs;
}

/// What the pairs say about (x, y, yaw), whatever the metric: a point on a line holds the motion across it, one
/// without a clear line holds both directions.
Observability observability_of(const std::vector<Pair>& pairs) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double total = 0.0;
  for (const Pair& pair : pairs) {
    Eigen::Matrix<double, 2, 3> jacobian;  // of the moved point
    jacobian << 1.0, 0.0, -pair.arm.y(),   //
        0.0, 1.0, pair.arm.x();
    if (pair.normal) {
      const Eigen::Vector3d across = jacobian.transpose() * *pair.normal;
      information += pair.weight * across * across.transpose();
    } else {
      information += pair.weight * jacobian.transpose() * jacobian;
    }
    centre += pair.weight * pair.arm;
    total += pair.weight;
  }
  centre /= total;
  double squared_arms = 0.0;
  for (const Pair& pair : pairs) squared_arms += pair.weight * (pair.arm - centre).squaredNorm();
  const double arm_m = std::max(std::sqrt(squared_arms / total), kLeastArmM);
  return loopstone::observability_of(information, centre, arm_m);
}

/// The pose after one step.
Pose2 step_to_points(const std::vector<Pair>& pairs, const Pose2& pose) {
  std::vector<Eigen::Vector2d> source;
  std::vector<Eigen::Vector2d> target;
  std::vector<double> weights;
  for (const Pair& pair : pairs) {
    source.push_back(pair.source);
    target.emplace_back(pair.arm + pose.translation() - pair.offset);
    weights.push_back(pair.weight);
  }
  return to_pose(align_rigidly<2>(source, target, weights));
}

Pose2 step_to_lines(const std::vector<Pair>& pairs, const Pose2& pose) {
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  for (const Pair& pair : pairs) {
    const Eigen::Vector2d& n = *pair.normal;
    const double turn = n.y() * pair.arm.x() - n.x() * pair.arm.y();
    gradient += pair.weight * n.dot(pair.offset) * Eigen::Vector3d(n.x(), n.y(), turn);
  }
  const Eigen::Vector3d step = observability_of(pairs).solve(gradient);
  return {pose.x + step.x(), pose.y + step.y(), wrap_angle(pose.yaw + step.z())};
}

Eigen::Vector3d difference(const Pose2& pose, const Pose2& from) {
  return {pose.x - from.x, pose.y - from.y, wrap_angle(pose.yaw - from.yaw)};
}

double rmse_of(const std::vector<Pair>& pairs, Metric metric) {
  double squared_sum = 0.0;
  double weight_sum = 0.0;
  for (const Pair& pair : pairs) {
    const double residual = pair.residual(metric);
    squared_sum += pair.weight * residual * residual;
    weight_sum += pair.weight;
  }
  return std::sqrt(squared_sum / weight_sum);
}

/// Takes back what the pairs cannot tell: along unobserved directions the guess stands.
void remap(MatchResult& result, const std::vector<Pair>& pairs, const Pose2& guess) {
  const Eigen::Vector3d kept =
      observability_of(pairs).observed_part(difference(result.target_T_source, guess));
  result.target_T_source = {guess.x + kept.x(), guess.y + kept.y(),
                            wrap_angle(guess.yaw + kept.z())};
}

/// Fills in how well the pairs at the final pose agree.
void judge(MatchResult& result, const std::vector<Pair>& pairs, std::size_t source_size,
           Metric metric, const IcpOptions& options) {
  const auto explained =
      static_cast<std::size_t>(std::count_if(pairs.begin(), pairs.end(), [&](const Pair& pair) {
        return std::abs(pair.residual(metric)) <= 3.0 * options.point_sigma_m;
      }));
  const auto share = [source_size](std::size_t count) {
    return static_cast<double>(count) / static_cast<double>(source_size);
  };
  result.pairs = static_cast<int>(pairs.size());
  result.rmse_m = rmse_of(pairs, metric);
  result.inlier_fraction = share(pairs.size());
  result.score = share(explained);
  const Observability observability = observability_of(pairs);
  result.covariance = observability.covariance(std::max(result.rmse_m, options.point_sigma_m));
  if (result.status == MatchStatus::kConverged && !observability.complete()) {
    result.status = MatchStatus::kDegenerate;
  }
}

MatchResult too_few_pairs(const Pose2& guess, std::size_t pairs, int iterations) {
  MatchResult result;
  result.target_T_source = guess;
  result.covariance = 100.0 * Eigen::Matrix3d::Identity();
  result.pairs = static_cast<int>(pairs);
  result.iterations = iterations;
  result.status = MatchStatus::kTooFewPairs;
  return result;
}

}  // namespace

IcpTarget make_icp_target(std::vector<Eigen::Vector2d> points) {
  PointIndex<2> index(std::move(points));
  auto normals = line_normals(index, kNormalNeighbours, kNormalRadiusM);
  return {std::move(index), std::move(normals)};
}

MatchResult match_icp(std::span<const Eigen::Vector2d> source, const IcpTarget& target,
                      const Pose2& guess_target_T_source, const IcpOptions& options) {
  const Metric metric = metric_from(options.metric);
  MatchResult result;
  result.target_T_source = guess_target_T_source;
  result.status = MatchStatus::kNotConverged;

  auto pairs = find_pairs(source, target, result.target_T_source, metric, options);
  double best_rmse_m = std::numeric_limits<double>::infinity();
  int best_iteration = 0;
  while (result.iterations < options.max_iterations) {
    if (pairs.size() < kMinPairs) {
      return too_few_pairs(guess_target_T_source, pairs.size(), result.iterations);
    }
    ++result.iterations;
    const Pose2 before = result.target_T_source;
    result.target_T_source =
        metric == Metric::kPoint ? step_to_points(pairs, before) : step_to_lines(pairs, before);
    pairs = find_pairs(source, target, result.target_T_source, metric, options);
    const Eigen::Vector3d step = difference(result.target_T_source, before);
    if (step.head<2>().norm() < options.tolerance_m && std::abs(step.z()) < options.tolerance_rad) {
      result.status = MatchStatus::kConverged;
      break;
    }
    const double rmse_m = pairs.empty() ? 0.0 : rmse_of(pairs, metric);
    if (rmse_m < (1.0 - kProgressShare) * best_rmse_m) {
      best_rmse_m = rmse_m;
      best_iteration = result.iterations;
    } else if (result.iterations - best_iteration >= kPatientSteps) {
      result.status = MatchStatus::kConverged;
      break;
    }
  }
  if (pairs.size() < kMinPairs) {
    return too_few_pairs(guess_target_T_source, pairs.size(), result.iterations);
  }
  if (!observability_of(pairs).complete()) {
    remap(result, pairs, guess_target_T_source);
    pairs = find_pairs(source, target, result.target_T_source, metric, options);
    if (pairs.size() < kMinPairs) {
      return too_few_pairs(guess_target_T_source, pairs.size(), result.iterations);
    }
  }
  judge(result, pairs, source.size(), metric, options);
  return result;
}

}  // namespace loopstone
