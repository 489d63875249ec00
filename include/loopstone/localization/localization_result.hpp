#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/base/words.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/odometry/trajectory.hpp"

namespace loopstone {

/// What a robot may think of its pose.
enum class LocalizationState {
  kTracking,  ///< the pose is right, by all that can be told
  kDoubtful,  ///< it may be right, or another place looks the same
  kLost,      ///< it is wrong, or there is none yet
};

constexpr auto words_of(LocalizationState /*any*/) {
  using enum LocalizationState;
  return std::array{Word{kTracking, "TRACKING"}, Word{kDoubtful, "DOUBTFUL"}, Word{kLost, "LOST"}};
}

/// How scans fit the map from the poses followed: means over a way, the last metres counting most.
struct FitOverWay {
  double explained = 0.0;
  double violations = 0.0;
  double unexpected = 0.0;
  double known = 0.0;
  double silent = 0.0;

  friend bool operator==(const FitOverWay&, const FitOverWay&) = default;
};

/// What speaks for and against a pose: the inputs of its probability.
struct PoseEvidence {
  double explained = 0.0;   ///< [0, 1], share of the returns where the map knows what is there
                            ///< that lie on a wall
  double violations = 0.0;  ///< [0, 1], share of the beams that went through a wall of the map
  double unexpected =
      0.0;  ///< [0, 1], share of the beams that ended well before any wall: people, new things
  double mass =
      0.0;  ///< [0, 1], belief in the best place, against other places and the rest of the map
  double precision =
      0.0;  ///< [0, 1], probability by the covariance that the pose is within 0.2 m and 5 deg
  double spread_m = 0.0;    ///< standard deviation of its particles' positions
  double spread_rad = 0.0;  ///< of their headings
  double innovation =
      /// registration against prediction, squared Mahalanobis distance / 3, mean of the last ones
      0.0;
  double followed_m = 0.0;  ///< path over which the hypothesis has held
  double known = 0.0;       ///< [0, 1], share of the returns where the map knows what is there
  double silent = 0.0;      ///< [0, 1], share of the beams without a return where a wall is near
  double unproven =
      0.0;  ///< [0, 1], how much was driven in vain on a map on which no place has held yet
  FitOverWay lately{};  ///< over about the last 1.5 m
  FitOverWay along{};   ///< over about the last 8 m
};

/// A place where the robot may be.
struct LocalizationHypothesis {
  Pose2 map_T_robot;
  double probability = 0.0;  ///< [0, 1], share of the belief
};

/// Where the robot is at a scan, and how far to trust that.
struct LocalizationEstimate {
  Stamp stamp;
  Pose2 map_T_robot;
  Pose2 odom_T_robot;  ///< by odometry since the first scan: smooth, drifts
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Zero();  ///< of map_T_robot, (x, y, yaw), map axes [m^2, m rad, rad^2]
  LocalizationState state = LocalizationState::kLost;
  double probability = 0.0;  ///< that the pose is within 0.2 m and 5 deg of the truth
  bool refined = false;      ///< by registration to the map; else the particles' mean
  int hypotheses = 0;        ///< places that the robot may be at,
  /// the most probable first, as the particles have them; map_T_robot is the first one's, refined
  std::vector<LocalizationHypothesis> places{};
  int particles = 0;
  int landmarks = 0;         ///< of the map, that this reading showed; among landmarks only
  double travelled_m = 0.0;  ///< path since the first scan, by odometry
  PoseEvidence evidence{};

  /// As REP-105 has it: moves when the pose is corrected.
  [[nodiscard]] Pose2 map_T_odom() const { return map_T_robot * odom_T_robot.inverse(); }
};

/// The belief at one moment, for pictures.
struct BeliefSnapshot {
  Stamp stamp;
  std::vector<Pose2> particles{};                    ///< map_T_robot
  std::vector<LocalizationHypothesis> hypotheses{};  ///< the most probable first
  std::vector<Eigen::Vector2f> points{};             ///< of the scan, robot frame [m]
  LocalizationEstimate estimate{};
};

/// A search of the map for the robot.
struct LocalizationSearch {
  Stamp stamp;
  std::string reason;      ///< "start", "lost", "doubtful", "jumped"
  bool whole_map = false;  ///< else near the pose believed in
  int poses_found = 0;
  int poses_added = 0;      ///< of these, places that nothing was known of
  double best_score = 0.0;  ///< [0, 1], share of the scan that the best explains
};

/// A change of state.
struct LocalizationChange {
  Stamp stamp;
  LocalizationState state = LocalizationState::kLost;
};

/// What localisation made of a log.
struct LocalizationResult {
  std::vector<LocalizationEstimate> estimates{};  ///< one a scan from the first pose on
  std::vector<BeliefSnapshot> snapshots{};
  std::vector<LocalizationSearch> searches{};
  std::vector<LocalizationChange> changes{};
  std::int64_t scans = 0;
  std::int64_t scans_dropped = 0;  ///< too few returns to use
  double path_length_m = 0.0;      ///< by odometry
  Stamp start{};                   ///< of the first scan, which may have no pose yet
  double duration_s = 0.0;         ///< of the recording, from there
  double search_s = 0.0;           ///< wall time spent in searches
  double filter_s = 0.0;           ///< wall time spent on everything else
  bool had_odometry = false;
  std::vector<std::string> warnings{};  ///< in plain words, for the user
  bool complete = true;                 ///< false when it was interrupted

  /// map_T_robot at every scan.
  [[nodiscard]] Trajectory trajectory() const;
};

}  // namespace loopstone
