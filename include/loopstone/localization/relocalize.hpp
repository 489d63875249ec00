#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/localization/localization_map.hpp"
#include "loopstone/localization/localization_scan.hpp"
#include "loopstone/sensor/laser_scan.hpp"

namespace loopstone {

/// What finding a robot by single scans decides by, beside what following it does.
struct RelocalizeNumbers {
  /// Chosen: of a scan that are held against the map, as LocalizationOptions::beams.
  int beams = 90;
  /// Measured by bench/localization_speed.py: with 96 in place of the search's 160 points the true
  /// pose is among the candidates as often, in less time.
  int search_points = 96;
  /// Chosen: a view from nearer than this to another one, as
  /// LocalizationOptions::update_distance_m, and turned by less, tells nothing new.
  double news_m = 0.1;
  double news_rad = 0.1;
  /// Derived: what the probability takes registration to disagree by with a prediction where there
  /// was none: chi-square divided by its degrees of freedom, on average.
  double first_innovation = 1.0;
};
inline constexpr RelocalizeNumbers kRelocalize{};

/// A scan, and where it was taken from.
struct TakenScan {
  LaserScan scan{};
  Pose2 robot_T_lidar{};
  /// Where the robot was when the scan was taken ("then"), seen from where it is at the moment
  /// whose map_T_robot is asked for: odom_T_robot.inverse() * odom_T_then, by odometry. The
  /// identity: the scan was taken at that moment.
  Pose2 robot_T_then{};
  Tangent2 velocity = Tangent2::Zero();  ///< of the robot [m/s, m/s, rad/s]; undoes the sweep
};

/// A pose that scans may have been taken from.
struct PlaceCandidate {
  Pose2 map_T_robot{};
  /// Of map_T_robot, (x, y, yaw), map axes [m^2, m rad, rad^2]; large along what scans leave open,
  /// as a corridor's axis.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  BeamFit fit{};  ///< what the map explains of the scans from there, and what contradicts it
  double probability = 0.0;  ///< that the robot is within 0.2 m and 5 deg of the pose
};

/// Where on a map scans may have been taken.
struct Relocalization {
  std::vector<PlaceCandidate> candidates{};  ///< the most probable first
  /// That the robot is at none of these places: elsewhere on the map, or not on it. What is left to
  /// 1 by this and the candidates is that it is at one of them, though farther from the pose than
  /// the probability allows.
  double none_probability = 1.0;
  bool complete = true;  ///< false: more places look alike than were looked into
};

/// Finds a robot on a map by one scan, from nothing: what a robot asks that was switched on, or
/// carried.
///
/// The scan is compared with every pose on the map (match_on_map); what explains it nearly as well
/// as the best is a candidate, with the pose that registration gives. Candidates share the belief
/// by how well each explains the scan, in which differences smaller than a cell of the map do not
/// count: rooms that look alike stay alike. A candidate's probability is its share, times the
/// probability that scans fit so from a right pose, learned from drives (pose_probability), times
/// that its covariance leaves it within 0.2 m and 5 deg.
///
/// A place that exists twice can't be told apart by any scan. Drive on, and ask a Localizer.
///
/// \param robot_T_lidar  where the laser sits
/// \return no candidates and none_probability 1 where no pose explains the scan.
/// Throws UsageError for a scan of fewer than 10 returns, and for a mount that is not finite.
/// Cost: docs/benchmarks.md. Deterministic, the same bytes for any number of threads. Thread-safe.
[[nodiscard]] Relocalization relocalize(const LocalizationMap& map, const LaserScan& scan,
                                        const Pose2& robot_T_lidar, Threads threads = {1});

/// The same by several scans: of lasers that look different ways, or of a few steps of the robot
/// with what odometry says of them. Candidates are those of the view with the most returns; all
/// views decide between them. Views from one place count as one.
/// Throws UsageError where no view has 10 returns, or a pose or velocity is not finite.
[[nodiscard]] Relocalization relocalize(const LocalizationMap& map,
                                        std::span<const TakenScan> scans, Threads threads = {1});

}  // namespace loopstone
