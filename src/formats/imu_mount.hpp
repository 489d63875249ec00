#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

namespace loopstone {

/// How an inertial unit sits in its robot.
struct ImuMount {
  Eigen::Quaterniond robot_R_imu = Eigen::Quaterniond::Identity();
  std::string warning{};  ///< when what tf says can't be, or nothing tells
  std::string note{};
};

/// By tf, held against gravity; by gravity alone when tf does not tell (its direction in the
/// horizontal then stays open, and means nothing for a gyro's yaw).
/// \param force  mean of what the accelerometers show while the robot is about level [m/s^2]:
///               points up where one is at work
[[nodiscard]] ImuMount imu_mount(const std::optional<Eigen::Quaterniond>& by_tf,
                                 const Eigen::Vector3d& force);

}  // namespace loopstone
