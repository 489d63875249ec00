#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/localization/localization_map.hpp"
#include "loopstone/sensor/laser_scan.hpp"

namespace loopstone {

/// What one laser shows: its returns, and a few of its beams, evenly spread.
struct SeenByLaser {
  Pose2 robot_T_lidar{};
  double range_max_m = 0.0;
  std::vector<Eigen::Vector2d> points_robot{};  ///< all returns, robot frame [m]
  std::vector<double> angles_rad{};             ///< of the beams kept, lidar frame
  std::vector<float> ranges_m{};                ///< likewise; +inf: nothing within range_max_m
};

/// A scan as localisation uses it, with what the robot's other lasers saw a moment ago.
struct LocalizationScan {
  std::vector<SeenByLaser> lasers{};            ///< one at least; the scan's own is the first
  std::vector<Eigen::Vector2d> points_robot{};  ///< all returns, robot frame at the stamp [m]
  std::vector<Eigen::Vector2f> weighed{};       ///< those that particles are weighed with

  [[nodiscard]] const Pose2& robot_T_lidar() const { return lasers.front().robot_T_lidar; }
};

/// \param count     of the beams to be kept
/// \param velocity  of the robot [m/s, m/s, rad/s], undoes the motion during the sweep
[[nodiscard]] SeenByLaser view_of_laser(const LaserScan& scan, const Pose2& robot_T_lidar,
                                        const Tangent2& velocity, int count);

/// \param lasers  one at least, in the robot's frame at one stamp
/// \param count   of the beams to be kept, of all lasers together, and of the returns to weigh with
[[nodiscard]] LocalizationScan view_together(std::vector<SeenByLaser> lasers, int count);

/// Of one laser alone.
[[nodiscard]] LocalizationScan view_for_localization(const LaserScan& scan,
                                                     const Pose2& robot_T_lidar,
                                                     const Tangent2& velocity, int count);

/// How the beams of a scan fit what the map shows from a pose. A beam beside an edge may be as long
/// as its neighbours: it is held against the longest and the shortest of the three.
struct BeamFit {
  double explained = 0.0;   ///< [0, 1], of the returns where the map knows what is there, the share
                            ///< that lies on a wall
  double violations = 0.0;  ///< [0, 1], share of the beams that went well beyond a wall and ended
                            ///< on none
  double unexpected = 0.0;  ///< [0, 1], share of the beams that ended well before the first wall,
                            ///< where the map is free
  double known = 0.0;       ///< [0, 1], share of the returns where the map knows what is there
  double silent = 0.0;      ///< [0, 1], share of the beams that came back from nothing where a wall
                            ///< is near: glass and dark things do so
};

/// Cost: one ray a beam, about 20 us for 90 beams.
[[nodiscard]] BeamFit fit_beams(const LocalizationScan& scan, const LocalizationMap& map,
                                const Pose2& map_T_robot);

}  // namespace loopstone
