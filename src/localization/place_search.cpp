#include "localization/place_search.hpp"

#include "geometry/symmetric_matrix.hpp"
#include "localization/map_tables.hpp"

namespace loopstone {

namespace {

/// The search calls a place sure when nothing else explains the scan nearly as well; none of a
/// thousand was wrong.
constexpr double kSureLogOdds = 7.0;

/// How widely particles are drawn around a pose that a search found: not too narrowly, as the
/// lattice is coarse, nor along a corridor farther than to the next pose found there.
Eigen::Matrix3d spread_of(const Eigen::Matrix3d& covariance) {
  constexpr double kLeastM = 0.05;
  constexpr double kMostM = 0.4;
  constexpr double kLeastRad = 0.03;
  const auto axes = symmetric_eigen(Eigen::Matrix2d(covariance.topLeftCorner<2, 2>()));
  const Eigen::Vector2d variances =
      axes.values.cwiseMax(kLeastM * kLeastM).cwiseMin(kMostM * kMostM);
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  spread.topLeftCorner<2, 2>() = axes.vectors * variances.asDiagonal() * axes.vectors.transpose();
  spread(2, 2) = std::clamp(covariance(2, 2), kLeastRad * kLeastRad, kMostM * kMostM);
  return spread;
}

/// Returns in the laser's frame.
std::vector<Eigen::Vector2d> seen_by_laser(const LocalizationScan& scan) {
  const Pose2 lidar_T_robot = scan.robot_T_lidar().inverse();
  std::vector<Eigen::Vector2d> points;
  points.reserve(scan.points_robot.size());
  for (const auto& point : scan.points_robot) points.emplace_back(lidar_T_robot * point);
  return points;
}

}  // namespace

PlacesFound find_places(const LocalizationScan& scan, const LocalizationMap& map, int points_max) {
  MapMatchOptions options;
  options.points_max = points_max;
  // A corridor alone has a place every metre, in two directions.
  options.poses_max = kPlacesMost;
  options.refined_max = 2 * kPlacesMost;
  const Pose2 lidar_T_robot = scan.robot_T_lidar().inverse();
  const MapMatch match = match_on_map(seen_by_laser(scan), map.tables().search, {}, options);
  PlacesFound found{.complete = match.complete};
  for (const MatchResult& pose : match.poses) {
    PoseBelief::Proposal proposal{
        .map_T_robot = {pose.target_T_source * lidar_T_robot, spread_of(pose.covariance)}};
    if (match.sure && !found.proposals.empty()) proposal.log_mass = -kSureLogOdds;
    found.proposals.push_back(proposal);
    found.matched.push_back(compound({pose.target_T_source, pose.covariance}, {lidar_T_robot}));
  }
  if (!match.poses.empty()) found.best_score = match.poses.front().score;
  return found;
}

std::vector<MatchResult> match_near(const LocalizationScan& scan, const LocalizationMap& map,
                                    const SearchWindow& window, const MapMatchOptions& options) {
  SearchWindow of_laser = window;
  of_laser.centre = window.centre * scan.robot_T_lidar();
  MapMatch match = match_on_map(seen_by_laser(scan), map.tables().search, of_laser, options);
  const Pose2 lidar_T_robot = scan.robot_T_lidar().inverse();
  for (MatchResult& pose : match.poses) pose.target_T_source = pose.target_T_source * lidar_T_robot;
  return std::move(match.poses);
}

}  // namespace loopstone
