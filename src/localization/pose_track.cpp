#include "localization/pose_track.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <utility>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/geometry/rigid_motion.hpp"
#include "loopstone/registration/field_match.hpp"

namespace loopstone {

namespace {

/// Registrations share the map's own errors from scan to scan, so each counts less than its
/// covariance says.
constexpr double kCovarianceFactor = 2.0;
/// What dead reckoning adds at least between two scans.
constexpr double kDriftM = 0.003;
constexpr double kDriftRad = 0.001;
/// Standard deviation of odometry's scale, which is the same all along the way.
constexpr double kScaleSigma = 0.015;
/// How odometry's errors change on the way: over a metre, a radian, a metre, a radian.
constexpr double kScaleWalk = 0.0007;
constexpr double kTurnWalk = 0.003;
constexpr double kCurveWalk = 0.001;
constexpr double kLagWalkS = 0.003;
/// A registration farther from the prediction than this (squared Mahalanobis distance, 3 degrees of
/// freedom) is not believed.
constexpr double kGate = 40.0;
/// Share of the newest registration in the mean innovation.
constexpr double kNewest = 0.15;
constexpr double kLeastExplained = 0.25;
/// Share of the newest registration in what registrations share.
constexpr double kNewestShared = 0.1;
/// Only scans that fit the map this well teach the offset of ranges.
constexpr double kWellExplained = 0.7;

/// A wall is known to a cell, so the kernel is no narrower than one.
FieldMatchOptions options_for(const MapField& field) {
  FieldMatchOptions options;
  options.kernel_width_m = std::max(options.kernel_width_m, field.resolution_m(0));
  return options;
}

/// Registers a scan from the prediction, on the finest level and from one above; where legs of
/// tables and chairs make valleys of their own, now and then from all around too. The prediction's
/// own valley is left only for one clearly deeper.
MatchResult best_match(std::span<const Eigen::Vector2d> points, const MapField& field,
                       const Pose2& guess, bool look_around) {
  constexpr double kDeeper = 0.8;
  constexpr double kAroundM = 0.1;
  const FieldMatchOptions options = options_for(field);
  const auto cost_of = [&](const MatchResult& match) {
    return field_cost(points, field, 0, match.target_T_source, options.kernel_width_m).cost;
  };
  MatchResult best = match_to_field(points, field, guess, options, 0);
  double best_cost =
      has_supported_pose(best.status) ? cost_of(best) : std::numeric_limits<double>::infinity();
  const auto consider = [&](const Pose2& start, std::size_t level) {
    const MatchResult match = match_to_field(points, field, start, options, level);
    if (!has_supported_pose(match.status)) return;
    const double cost = cost_of(match);
    if (!(cost < kDeeper * best_cost)) return;
    best = match;
    best_cost = cost;
  };
  consider(guess, 1);
  if (look_around) {
    for (const double x : {-kAroundM, 0.0, kAroundM}) {
      for (const double y : {-kAroundM, 0.0, kAroundM})
        consider({guess.x + x, guess.y + y, guess.yaw}, 0);
    }
  }
  return best;
}

/// The returns that may lie on a wall, by the pose foretold and its covariance: people and what
/// else stands in free space must not draw the pose. All of them where too few are left.
std::vector<Eigen::Vector2d> near_walls(std::vector<Eigen::Vector2d> points, const MapField& field,
                                        const PoseWithCovariance2& foretold) {
  constexpr double kNearM = 0.3;
  constexpr double kSigmas = 3.0;
  constexpr double kLeastShare = 0.3;
  const Eigen::Matrix3d& covariance = foretold.covariance;
  const double sigma_m = std::sqrt(std::max(covariance(0, 0), covariance(1, 1)));
  const double sigma_rad = std::sqrt(covariance(2, 2));
  const Grid<float>& distances = field.distances();
  std::vector<Eigen::Vector2d> near;
  for (const auto& point : points) {
    const Cell cell = distances.frame().cell_of(foretold.pose * point);
    const double reach_m = kNearM + kSigmas * (sigma_m + sigma_rad * point.norm());
    if (static_cast<double>(distances.value_or(cell, 0.0F)) <= reach_m) near.push_back(point);
  }
  const double least = kLeastShare * static_cast<double>(points.size());
  return static_cast<double>(near.size()) < least ? std::move(points) : near;
}

/// What a step adds to the covariance of the pose, map axes.
Eigen::Matrix3d motion_noise(const Pose2& before, const PoseWithCovariance2& step) {
  Eigen::Matrix3d noise = compound({before, Eigen::Matrix3d::Zero()}, step).covariance;
  noise.diagonal() += Eigen::Vector3d(kDriftM * kDriftM, kDriftM * kDriftM, kDriftRad * kDriftRad);
  return noise;
}

/// How much odometry's errors may have changed on a step.
Eigen::Vector4d odometry_walk(double way_m, double turn_rad) {
  return {kScaleWalk * kScaleWalk * way_m, kTurnWalk * kTurnWalk * std::abs(turn_rad),
          kCurveWalk * kCurveWalk * way_m, kLagWalkS * kLagWalkS * std::abs(turn_rad)};
}

}  // namespace

Eigen::Matrix2d scale_covariance(const Eigen::Matrix2d& position, const Eigen::Vector2d& way) {
  const double length = way.norm();
  if (!(length > 0.0)) return Eigen::Matrix2d::Zero();
  const Eigen::Vector2d along = way / length;
  const double sigma = std::sqrt(std::max(0.0, along.dot(position * along)));
  const double growth = 2.0 * kScaleSigma * sigma * length + std::pow(kScaleSigma * length, 2);
  return growth * along * along.transpose();
}

Eigen::Matrix2d lasting_covariance(const Eigen::Matrix2d& position, double step_sigma_m) {
  const auto axes = symmetric_eigen(position);
  const Eigen::Vector2d sigmas = axes.values.cwiseMax(0.0).cwiseSqrt();
  return 2.0 * step_sigma_m * axes.vectors * sigmas.asDiagonal() * axes.vectors.transpose();
}

Pose2 OdometryErrors::corrected(const Pose2& motion, const Tangent2& velocity_change) const {
  const Eigen::Vector2d way =
      (1.0 + mean[0]) * motion.translation() + mean[3] * velocity_change.head<2>();
  return {way.x(), way.y(),
          (1.0 + mean[1]) * motion.yaw + mean[2] * way.x() + mean[3] * velocity_change.z()};
}

PoseTrack::PoseTrack(const PoseWithCovariance2& map_T_robot, const OdometryErrors& errors)
    : map_T_robot_(map_T_robot.pose), errors_(errors.mean), covariance_(Matrix7::Zero()) {
  covariance_.topLeftCorner<3, 3>() = map_T_robot.covariance;
  covariance_.bottomRightCorner<4, 4>() = errors.covariance;
}

void PoseTrack::advance(const PoseWithCovariance2& motion) {
  Matrix7 noise = Matrix7::Zero();
  noise.topLeftCorner<3, 3>() = motion_noise(map_T_robot_, motion);
  const Eigen::Matrix2d& step = motion.covariance.topLeftCorner<2, 2>();
  noise.topLeftCorner<2, 2>() +=
      lasting_covariance(covariance_.topLeftCorner<2, 2>(), std::sqrt(0.5 * step.trace()));
  advance(motion.pose, Matrix7::Identity(), noise);
}

void PoseTrack::advance(const OdometryStep& told) {
  const Pose2& motion = told.motion.pose;
  const PoseWithCovariance2 step{errors().corrected(motion, told.velocity_change),
                                 told.motion.covariance};
  const Eigen::Matrix2d turn = map_T_robot_.rotation();
  Matrix7 change = Matrix7::Identity();
  change.block<2, 1>(0, 3) = turn * motion.translation();
  change(2, 4) = motion.yaw;
  change(2, 5) = motion.x;
  change.block<2, 1>(0, 6) = turn * told.velocity_change.head<2>();
  change(2, 6) = told.velocity_change.z();
  Matrix7 noise = Matrix7::Zero();
  noise.topLeftCorner<3, 3>() = motion_noise(map_T_robot_, step);
  noise.diagonal().tail<4>() = odometry_walk(step.pose.translation().norm(), motion.yaw);
  advance(step.pose, change, noise);
}

/// \param change  of pose and errors by odometry's errors, one at the pose itself
void PoseTrack::advance(const Pose2& step, const Matrix7& change, const Matrix7& noise) {
  const Pose2 before = map_T_robot_;
  map_T_robot_ = before * step;
  const Eigen::Vector2d way = map_T_robot_.translation() - before.translation();
  Matrix7 whole = change;
  whole.block<2, 1>(0, 2) << -way.y(), way.x();
  covariance_ = whole * covariance_ * whole.transpose() + noise;
}

std::vector<Eigen::Vector2d> RangeOffset::applied(std::span<const Eigen::Vector2d> points_robot,
                                                  const Eigen::Vector2d& laser_robot,
                                                  double more) const {
  std::vector<Eigen::Vector2d> moved;
  moved.reserve(points_robot.size());
  for (const auto& point : points_robot)
    moved.emplace_back(point + (metres_ + more) * (point - laser_robot).normalized());
  return moved;
}

void RangeOffset::learn(std::span<const Eigen::Vector2d> points_robot,
                        const Eigen::Vector2d& laser_robot, const MapField& field,
                        const Pose2& map_T_robot) {
  constexpr double kStepM = 0.01;
  constexpr double kNewestCost = 0.1;
  constexpr double kFastestM = 0.003;  // in one scan
  const FieldMatchOptions options = options_for(field);
  const auto cost_with = [&](double more) {
    const auto points = applied(points_robot, laser_robot, more);
    const MatchResult match = match_to_field(points, field, map_T_robot, options, 0);
    return field_cost(points, field, 0, match.target_T_source, options.kernel_width_m).cost /
           static_cast<double>(points.size());
  };
  const double less = cost_with(-kStepM);
  const double same = cost_with(0.0);
  const double more = cost_with(kStepM);
  slope_ += kNewestCost * ((more - less) / (2.0 * kStepM) - slope_);
  curvature_ += kNewestCost * ((more - 2.0 * same + less) / (kStepM * kStepM) - curvature_);
  // Newton's step where the cost is curved, else down the slope.
  const double step = curvature_ > 0.0 ? -0.3 * slope_ / curvature_ : (slope_ > 0.0 ? -1.0 : 1.0);
  const double cell = field.resolution_m(0);
  metres_ = std::clamp(metres_ + std::clamp(step, -kFastestM, kFastestM), -cell, cell);
}

void SharedError::add(const Eigen::Matrix3d& covariance) {
  if (!mean_) mean_ = covariance;
  *mean_ += kNewestShared * (covariance - *mean_);
}

bool PoseTrack::refine(std::span<const Eigen::Vector2d> points_robot,
                       const Eigen::Vector2d& laser_robot, const MapField& field,
                       RangeOffset& offset) {
  const PoseWithCovariance2 foretold = map_T_robot();
  const auto points = near_walls(offset.applied(points_robot, laser_robot), field, foretold);
  constexpr int kLookAroundEvery = 8;
  const bool look_around = ++registered_ % kLookAroundEvery == 0;
  const MatchResult match = best_match(points, field, foretold.pose, look_around);
  if (!has_supported_pose(match.status) || match.score < kLeastExplained) {
    innovation_ += kNewest * (kGate / 3.0 - innovation_);
    return false;
  }
  const Eigen::Matrix3d noise = kCovarianceFactor * match.covariance;
  if (match.status == MatchStatus::kConverged) shared_.add(match.covariance);
  const Eigen::Vector3d innovation =
      RigidMotion<2>::difference(match.target_T_source, foretold.pose);
  const Eigen::LDLT<Eigen::Matrix3d> total(foretold.covariance + noise);
  const double distance2 = innovation.dot(total.solve(innovation));
  innovation_ += kNewest * (std::min(distance2, kGate) / 3.0 - innovation_);
  if (!(distance2 < kGate)) return false;
  const Eigen::Matrix<double, 7, 3> gain = total.solve(covariance_.topRows<3>()).transpose();
  const Eigen::Matrix<double, 7, 1> step = gain * innovation;
  map_T_robot_ = RigidMotion<2>::moved(map_T_robot_, step.head<3>());
  errors_ += step.tail<4>();
  // Joseph's form stays symmetric and positive.
  Matrix7 rest = Matrix7::Identity();
  rest.leftCols<3>() -= gain;
  covariance_ = rest * covariance_ * rest.transpose() + gain * noise * gain.transpose();
  constexpr int kLearnEvery = 4;
  if (match.status == MatchStatus::kConverged && match.score > kWellExplained &&
      ++refined_ % kLearnEvery == 0) {
    offset.learn(points_robot, laser_robot, field, map_T_robot_);
  }
  return true;
}

}  // namespace loopstone
