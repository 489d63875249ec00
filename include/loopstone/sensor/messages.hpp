#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/geometry/pose3.hpp"
#include "loopstone/sensor/laser_scan.hpp"

namespace loopstone {

/// Encoder counts of the four wheels [front right, front left, rear right, rear left].
/// Since the previous reading, or absolute when WheelModel::counts_are_cumulative.
struct WheelTicks {
  Stamp stamp;
  std::array<std::int64_t, 4> counts{};

  template <typename Archive>
  void archive(Archive& a) {
    a(stamp, counts);
  }
};

/// A pose that the robot's own dead reckoning reported: odom_T_robot.
struct OdometryPose {
  Stamp stamp;
  Pose2 odom_T_robot;

  template <typename Archive>
  void archive(Archive& a) {
    a(stamp, odom_T_robot);
  }
};

/// One reading of an inertial unit, axes aligned with the robot's (x forward, y left, z up).
struct ImuSample {
  Stamp stamp;
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d linear_acceleration_m_s2 = Eigen::Vector3d::Zero();

  template <typename Archive>
  void archive(Archive& a) {
    a(stamp, angular_velocity_rad_s, linear_acceleration_m_s2);
  }
};

/// Which pictures an RGB-D camera took and where they are; the pixels are loaded when somebody
/// needs them.
struct RgbdFrame {
  Stamp stamp;              ///< of the depth picture, or of the colour picture when it is alone
  Stamp colour_stamp;       ///< the cameras need not be synchronised
  std::string colour_path;  ///< a file, or the topic of a recording; empty: there is only depth
  std::string depth_path;   ///< the same; empty: there is only colour
  /// Of pictures that are messages of a recording: their numbers there, for LogReader::pictures().
  /// Negative: they are files.
  std::int64_t colour_message = -1;
  std::int64_t depth_message = -1;
  /// Of a camera that moves on the robot: where it was at the depth picture's stamp. Absent: where
  /// the robot's model says.
  std::optional<Pose3> robot_T_camera{};
};

using SensorMessage = std::variant<LaserScan, OdometryPose, WheelTicks, ImuSample, RgbdFrame>;

[[nodiscard]] inline Stamp stamp_of(const SensorMessage& message) {
  return std::visit([](const auto& m) { return m.stamp; }, message);
}

}  // namespace loopstone
