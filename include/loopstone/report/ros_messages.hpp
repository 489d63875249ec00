#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/localization/localization_result.hpp"
#include "loopstone/localization/localizer.hpp"
#include "loopstone/messages/message_types.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/slam/map_update.hpp"

// Where a robot is, as the messages by which its other programs are told. The map's frame is "map".

namespace loopstone {

/// What a robot calls its frames.
struct RobotFrames {
  std::string odom = "odom";
  std::string base = "base_link";
};

/// Transforms of tf that lead from the map to the robot by its own odometry, as REP-105 has them:
/// whoever asks tf adds what the robot's odometry tells now to what it was at the last scan.
///
///   RobotTransforms transforms(frames);
///   while (auto message = log.next()) {
///     transforms.add(*message);
///     mapper.add(*message);
///     while (auto update = mapper.next_update())
///       send(transforms.at(update->stamp, update->map_T_robot(), update->odom_T_robot));
///   }
class RobotTransforms {
 public:
  explicit RobotTransforms(RobotFrames frames) : frames_(std::move(frames)) {}

  /// What is mapped or localised by. Of it the odometry of the last seconds is kept.
  void add(const SensorMessage& message);

  /// map to odom. Of a robot that has told no odometry also odom to base.
  /// \param odom_T_robot  the mapper's or the localiser's: a frame of its own beside the robot's
  [[nodiscard]] msg::TFMessage at(Stamp stamp, const Pose2& map_T_robot,
                                  const Pose2& odom_T_robot) const;

 private:
  RobotFrames frames_;
  Trajectory odometry_{};
};

/// \param covariance  of map_T_robot, (x, y, yaw), map axes [m^2, m rad, rad^2]
[[nodiscard]] msg::PoseWithCovarianceStamped pose_message(Stamp stamp, const Pose2& map_T_robot,
                                                          const Eigen::Matrix3d& covariance);

/// Where somebody says that the robot is. Standard deviations of 0 are those of InitialPose.
/// Nothing when it is no pose.
[[nodiscard]] std::optional<InitialPose> initial_pose_of(
    const msg::PoseWithCovarianceStamped& message);

/// What holds the pose, and faults that begin or end, each by its own name.
[[nodiscard]] std::vector<msg::DiagnosticStatus> diagnostics_of(const MapUpdate& update);
[[nodiscard]] msg::DiagnosticStatus diagnostic_of(const LocalizationEstimate& estimate);

}  // namespace loopstone
