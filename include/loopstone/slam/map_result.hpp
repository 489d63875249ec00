#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/mapping/map_quality.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/odometry/odometry_check.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/slam/calibration.hpp"
#include "loopstone/slam/laser_check.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/loose_parts.hpp"
#include "loopstone/slam/map_verdict.hpp"
#include "loopstone/slam/path_break.hpp"
#include "loopstone/slam/pose_covariances.hpp"
#include "loopstone/slam/step_drift.hpp"

namespace loopstone {

/// The figures of a run.
struct MapStatistics {
  std::int64_t scans = 0;
  std::int64_t scans_dropped = 0;  ///< too few valid beams to use
  std::int64_t key_scans = 0;
  std::int64_t key_scans_thinned =
      0;  ///< of them, where older submaps had seen all: not in the graph
  std::int64_t submaps = 0;
  std::int64_t loop_closures_accepted = 0;
  std::int64_t loop_closures_rejected = 0;
  std::int64_t searches = 0;  ///< scans for which odometry and refinement alone were not trusted
  double degenerate_travel_m = 0.0;  ///< path during which a direction was unobserved by the laser
  double path_length_m = 0.0;
  double odometry_distrusted_s =
      0.0;                          ///< time during which odometry, or a part of it, was not used
  std::int64_t odometry_jumps = 0;  ///< single motions that nothing but a jump explains
  double odometry_translation_scale = 0.0;  ///< odometry's travel / the laser's; 0: unknown
  double odometry_rotation_scale = 0.0;
  /// Direction in which the laser sees the robot go while odometry goes straight.
  std::optional<double> laser_heading_offset_rad{};
  /// Correlation of the turns that wheels and gyro tell.
  std::optional<double> wheels_with_gyro{};
  bool odometry_is_told = false;    ///< as poses of dead reckoning, not as counts of the wheels
  std::int64_t scans_repeated = 0;  ///< most in a row the same to the last bit, without odometry
  double duration_s = 0.0;          ///< of the recording
  double front_end_s = 0.0;         ///< wall time of the steps, which overlap
  double loop_closing_s = 0.0;
  double optimisation_s = 0.0;
  double adjustment_s = 0.0;
  double rendering_s = 0.0;
  double judging_s = 0.0;
  double graph_cost = 0.0;               ///< sum e^T Omega e
  double surface_spread_before_m = 0.0;  ///< of points about their walls, see SurfaceAdjustment
  double surface_spread_m = 0.0;         ///< after the adjustment; 0 when there was none

  /// What grows during a run; the rest is counted at its end.
  template <typename Archive>
  void archive(Archive& a) {
    a(scans_dropped, key_scans, searches, degenerate_travel_m, front_end_s);
  }
};

/// A drive that another one came before (Mapper::begin_drive).
struct MappedDrive {
  std::size_t first_scan = 0;  ///< its place among all scans
  /// What is added to its stamps, so that it comes after those before; nothing until a message of
  /// it has come.
  std::optional<std::int64_t> clock_shift_ns{};
  Pose2 local_T_drive{};  ///< where it was taken to begin
  // Told when the map is finished:
  Stamp begins{};  ///< its first scan, on the map's clock
  std::int64_t scans = 0;
  int closures = 0;  ///< that stand and tie it to those before

  /// It was found on the map of those before: all is one map.
  [[nodiscard]] bool is_joined() const { return closures > 0; }

  template <typename Archive>
  void archive(Archive& a) {
    a(first_scan, clock_shift_ns, local_T_drive);
  }
};

/// What the mapper made of a log.
struct MapResult {
  Trajectory trajectory;           ///< map_T_robot at every scan
  Trajectory odometry;             ///< odom_T_robot at every scan, from dead reckoning alone
  std::vector<Stamp> node_stamps;  ///< of the graph's poses
  PoseGraph graph;
  PoseCovariances covariances;    ///< of the graph's poses
  std::vector<StepDrift> drifts;  ///< of the path alone, from each node to the next
  PathSurfaces path_surfaces;     ///< what holds it between them
  std::vector<LoopClosure> loop_closures;
  OccupancyMap map;
  std::string map_failure;  ///< why there is none (too large); empty when there is
  std::vector<OdometryEpisode> odometry_episodes;  ///< when odometry was found wrong, and how
  std::vector<LaserEpisode> laser_episodes;        ///< when the laser was blocked or frozen
  std::vector<PathBreak> breaks;                   ///< when the laser did not hold the pose
  std::vector<MappedDrive> drives;                 ///< after the first; none: there was one
  Calibration calibration;  ///< how the sensors sit and count, as the drive tells
  MapStatistics statistics;
  MapQuality quality;                 ///< what the scans say about each other
  GraphQuality graph_quality;         ///< what the pose graph says about itself
  GraphTies ties;                     ///< what hangs loosely, and where a direction is open
  MapVerdict verdict;                 ///< of both, in plain words
  std::vector<std::string> warnings;  ///< in plain words, for the user
  bool complete = true;               ///< false when it was interrupted

  /// What was added to the stamps of a drive's own log.
  [[nodiscard]] Duration clock_shift(std::size_t drive) const;
  /// The trajectory cut into its drives, each on its own clock.
  [[nodiscard]] std::vector<Trajectory> trajectories() const;

  /// Covariance of map_T_robot at a stamp against the first pose: (x, y, yaw), axes of the map; in
  /// between key scans that of both, and more where the laser did not hold the pose. Covariances
  /// must be available.
  [[nodiscard]] Eigen::Matrix3d covariance_at(Stamp stamp) const;
};

}  // namespace loopstone
