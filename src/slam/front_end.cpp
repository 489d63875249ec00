#include "loopstone/slam/front_end.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "loopstone/registration/correlative_search.hpp"

namespace loopstone {

namespace {

/// A scan with fewer points says too little to be aligned or mapped.
constexpr std::size_t kMinPoints = 20;
/// Wheels: share of the motion that may be wrong, and what is uncertain even at rest (stamps, quantisation).
constexpr double kWheelShare = 0.15;
constexpr double kWheelRestM = 0.01;
constexpr double kWheelRestRad = 0.01;
constexpr double kWheelRadPerM = 0.03;
/// Without wheels: how much the velocity may change between scans.
constexpr double kCoastRestM = 0.10;
constexpr double kCoastRestRad = 0.15;
/// The search must explain this much more of the scan before it overrules odometry and refinement.
constexpr double kSearchGain = 0.08;
constexpr double kSearchMinScore = 0.25;
constexpr std::size_t kSearchPoints = 200;

Eigen::Matrix3d information_of(const Pose2& local_T_robot, double sigma_forward, double sigma_side,
                               double sigma_yaw) {
  const Eigen::Matrix2d rotation = local_T_robot.rotation();
  const Eigen::Vector2d weights(1.0 / (sigma_forward * sigma_forward),
                                1.0 / (sigma_side * sigma_side));
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  information.topLeftCorner<2, 2>() = rotation * weights.asDiagonal() * rotation.transpose();
  information(2, 2) = 1.0 / (sigma_yaw * sigma_yaw);
  return information;
}

std::vector<Eigen::Vector2d> thinned_positions(std::span<const SurfacePoint> surfaces,
                                               std::size_t count) {
  const std::size_t stride = std::max<std::size_t>(1, surfaces.size() / count);
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < surfaces.size(); i += stride)
    points.emplace_back(surfaces[i].position.cast<double>());
  return points;
}

}  // namespace

FrontEnd::FrontEnd(const FrontEndOptions& options, const GridMatchOptions& match,
                   const SubmapOptions& submap)
    : options_(options), match_options_(match), submap_options_(submap) {}

TrackedScan FrontEnd::add(const LaserScan& scan, const Pose2& robot_T_lidar,
                          const std::optional<Pose2>& odom_T_robot) {
  TrackedScan tracked;
  const Prediction prediction = predict(scan, odom_T_robot);
  tracked.local_T_robot = prediction.local_T_robot;

  // Motion during the sweep: from the last scan to the prediction.
  Tangent2 velocity = Tangent2::Zero();
  if (last_stamp_ && scan.stamp > *last_stamp_) {
    velocity = log(last_pose_.inverse() * prediction.local_T_robot) /
               (scan.stamp - *last_stamp_).seconds();
  }
  const SurfaceOptions surface_options{.range_max_m = options_.range_max_m,
                                       .points_max = options_.points_max};
  const auto surfaces = surface_points(scan, robot_T_lidar, velocity, surface_options, beams_);
  tracked.used = surfaces.size() >= kMinPoints;

  if (tracked.used && !active_.empty()) {
    const MatchResult match = align(surfaces, prediction, &tracked.searched);
    tracked.local_T_robot = match.target_T_source;
    tracked.covariance = match.covariance;
    tracked.status = match.status;
    tracked.score = match.score;
  } else if (tracked.used) {
    tracked.status = MatchStatus::kConverged;
    tracked.score = 1.0;
  } else {
    tracked.covariance = prediction.information.inverse();
  }

  if (last_stamp_ && scan.stamp > *last_stamp_) {
    velocity_ =
        log(last_pose_.inverse() * tracked.local_T_robot) / (scan.stamp - *last_stamp_).seconds();
  }
  if (tracked.used && (active_.empty() || moved_enough(tracked.local_T_robot))) {
    insert(surfaces, scan, robot_T_lidar, tracked);
  }
  last_stamp_ = scan.stamp;
  last_pose_ = tracked.local_T_robot;
  last_odometry_ = odom_T_robot;
  return tracked;
}

FrontEnd::Prediction FrontEnd::predict(const LaserScan& scan,
                                       const std::optional<Pose2>& odom_T_robot) const {
  if (!last_stamp_) return {Pose2{}, information_of(Pose2{}, 1.0, 1.0, 1.0)};
  if (odom_T_robot && last_odometry_) {
    const Pose2 motion = last_odometry_->inverse() * *odom_T_robot;
    const Pose2 pose = last_pose_ * motion;
    const double distance = std::hypot(motion.x, motion.y);
    const double sigma = kWheelRestM + kWheelShare * distance;
    const double sigma_yaw =
        kWheelRestRad + kWheelShare * std::abs(motion.yaw) + kWheelRadPerM * distance;
    return {pose, information_of(pose, sigma, sigma, sigma_yaw)};
  }
  const double seconds = std::clamp((scan.stamp - *last_stamp_).seconds(), 0.0, 1.0);
  const Pose2 pose = last_pose_ * exp(Tangent2(velocity_ * seconds));
  return {pose, information_of(pose, kCoastRestM, kCoastRestM, kCoastRestRad)};
}

MatchResult FrontEnd::align(std::span<const SurfacePoint> surfaces, const Prediction& prediction,
                            bool* searched) const {
  const ActiveSubmap& target = active_.front();
  const Pose2 submap_T_local = target.local_T_submap.inverse();
  // The prior turns with the frame.
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = target.local_T_submap.rotation();
  const PosePrior2 prior{submap_T_local * prediction.local_T_robot,
                         turn.transpose() * prediction.information * turn};
  const auto& grid = target.submap.surfaces();
  MatchResult match =
      match_to_grid(surfaces, grid, prior.target_T_source, prior, match_options_, 1);

  if (match.status == MatchStatus::kTooFewPairs || match.score < options_.trusted_score) {
    *searched = true;
    const auto pyramid =
        target.submap.freeze().search_pyramid(submap_options_, options_.search_half_xy_m);
    const auto found = search_branch_and_bound(
        thinned_positions(surfaces, kSearchPoints), pyramid,
        {prior.target_T_source, options_.search_half_xy_m, options_.search_half_yaw_rad},
        kSearchMinScore);
    if (found.found) {
      const MatchResult other =
          match_to_grid(surfaces, grid, found.target_T_source, prior, match_options_, 0);
      if (other.status != MatchStatus::kTooFewPairs && other.score > match.score + kSearchGain)
        match = other;
    }
    if (match.status == MatchStatus::kTooFewPairs) {
      match.target_T_source = prior.target_T_source;
      match.covariance = prior.information.inverse();
    }
  }
  match.target_T_source = target.local_T_submap * match.target_T_source;
  match.covariance = turn * match.covariance * turn.transpose();
  return match;
}

bool FrontEnd::moved_enough(const Pose2& local_T_robot) const {
  return std::hypot(local_T_robot.x - last_key_.x, local_T_robot.y - last_key_.y) >=
             options_.key_distance_m ||
         std::abs(wrap_angle(local_T_robot.yaw - last_key_.yaw)) >= options_.key_angle_rad;
}

void FrontEnd::insert(std::span<const SurfacePoint> surfaces, const LaserScan& scan,
                      const Pose2& robot_T_lidar, TrackedScan& tracked) {
  const double step =
      std::hypot(tracked.local_T_robot.x - last_key_.x, tracked.local_T_robot.y - last_key_.y);
  for (auto& active : active_) active.travelled_m += step;
  const bool start_next =
      active_.empty() || active_.back().travelled_m >= 0.5 * options_.submap_length_m;
  if (start_next) {
    if (active_.size() == 2) {
      tracked.finished.push_back(
          {active_.front().submap.freeze(), active_.front().first_key, key_count_ - 1});
      active_.erase(active_.begin());
    }
    active_.push_back({Submap(submap_options_), tracked.local_T_robot, key_count_, 0.0});
  }
  for (auto& active : active_) {
    active.submap.insert(surfaces, scan, robot_T_lidar,
                         active.local_T_submap.inverse() * tracked.local_T_robot, beams_);
  }
  last_key_ = tracked.local_T_robot;
  ++key_count_;
  tracked.key = true;
}

std::vector<FinishedSubmap> FrontEnd::finish() {
  std::vector<FinishedSubmap> finished;
  for (const auto& active : active_)
    finished.push_back({active.submap.freeze(), active.first_key, key_count_ - 1});
  active_.clear();
  return finished;
}

}  // namespace loopstone
