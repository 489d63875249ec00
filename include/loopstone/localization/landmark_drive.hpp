#pragma once

#include <span>
#include <string>
#include <vector>

#include "loopstone/localization/landmark_mapping.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/sensor/landmark_reading.hpp"
#include "loopstone/sensor/messages.hpp"

namespace loopstone {

/// A drive of which nothing is known but odometry and what was seen of landmarks, as a graph: a
/// pose at each reading, and the motions between them.
struct LandmarkDrive {
  PoseGraph graph{};  ///< at the poses of odometry; the first is the origin
  std::vector<Stamp> stamps{};
  std::vector<std::vector<LandmarkObservation>> seen{};  ///< from each pose
  bool had_odometry = false;
};

/// \param odometry  by stamp; where it tells nothing the robot is taken to keep its velocity
/// \param readings  by stamp; those without anything seen, and those not newer than the one before,
///                  are left out
[[nodiscard]] LandmarkDrive drive_among_landmarks(std::span<const OdometryPose> odometry,
                                                  std::span<const LandmarkReading> readings);

/// Path and landmarks of a drive.
struct LandmarkDriveMap {
  LandmarkMapping mapping{};
  Trajectory trajectory{};  ///< map_T_robot at each reading
  Trajectory odometry{};    ///< odom_T_robot at each reading, from odometry alone
  double path_length_m = 0.0;
  double duration_s = 0.0;
  std::vector<std::string> warnings{};
};

/// Throws as map_landmarks does.
[[nodiscard]] LandmarkDriveMap map_drive(const LandmarkDrive& drive,
                                         const LandmarkMappingOptions& options);

}  // namespace loopstone
