#include "loopstone/report/ros_messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <variant>

#include "formats/ros_geometry.hpp"
#include "formats/topic_names.hpp"
#include "report/map_messages.hpp"

namespace loopstone {
namespace {

/// Poses of odometry that are kept: 10 s of a fast one.
constexpr std::size_t kOdometryKept = 2000;
/// Of the six of space, x, y and yaw.
constexpr std::array<std::size_t, 3> kPlaces{0, 1, 5};

std::uint8_t level_of(LocalizationState state) {
  switch (state) {
    case LocalizationState::kTracking:
      return msg::DiagnosticStatus::kOk;
    case LocalizationState::kDoubtful:
      return msg::DiagnosticStatus::kWarn;
    case LocalizationState::kLost:
      break;
  }
  return msg::DiagnosticStatus::kError;
}

double sigma_or(double variance, double otherwise) {
  return std::isfinite(variance) && variance > 0.0 ? std::sqrt(variance) : otherwise;
}

}  // namespace

void RobotTransforms::add(const SensorMessage& message) {
  const auto* pose = std::get_if<OdometryPose>(&message);
  if (pose == nullptr) return;
  (void)odometry_.append(pose->stamp, pose->odom_T_robot);
  const auto& poses = odometry_.poses();
  if (poses.size() >= 2 * kOdometryKept)
    odometry_ = Trajectory(std::vector<StampedPose2>(poses.end() - kOdometryKept, poses.end()));
}

msg::TFMessage RobotTransforms::at(Stamp stamp, const Pose2& map_T_robot,
                                   const Pose2& odom_T_robot) const {
  const std::optional<Pose2> told = odometry_.at_clamped(stamp);
  const Pose2 odom_T_base = told.value_or(odom_T_robot);
  msg::TFMessage message{
      {transform_message(stamp, kMapFrame, frames_.odom, map_T_robot * odom_T_base.inverse())}};
  if (!told)
    message.transforms.push_back(transform_message(stamp, frames_.odom, frames_.base, odom_T_base));
  return message;
}

msg::PoseWithCovarianceStamped pose_message(Stamp stamp, const Pose2& map_T_robot,
                                            const Eigen::Matrix3d& covariance) {
  msg::PoseWithCovarianceStamped message{.header = {stamp, kMapFrame}};
  message.pose.pose = to_message(map_T_robot);
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      message.pose.covariance[6 * kPlaces[row] + kPlaces[column]] =
          covariance(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column));
  }
  return message;
}

std::optional<InitialPose> initial_pose_of(const msg::PoseWithCovarianceStamped& message) {
  const auto pose = to_pose3(message.pose.pose);
  if (!pose) return {};
  InitialPose initial{.map_T_robot = to_pose2(*pose)};
  const auto variance = [&](std::size_t place) { return message.pose.covariance[7 * place]; };
  initial.sigma_m = std::max(sigma_or(variance(kPlaces[0]), initial.sigma_m),
                             sigma_or(variance(kPlaces[1]), initial.sigma_m));
  initial.sigma_rad = sigma_or(variance(kPlaces[2]), initial.sigma_rad);
  return initial;
}

std::vector<msg::DiagnosticStatus> diagnostics_of(const MapUpdate& update) {
  std::vector<msg::DiagnosticStatus> told{diagnostic_of(update)};
  for (const MapEvent& event : update.events) {
    if (auto fault = diagnostic_of(event)) told.push_back(std::move(*fault));
  }
  return told;
}

msg::DiagnosticStatus diagnostic_of(const LocalizationEstimate& estimate) {
  return {.level = level_of(estimate.state),
          .name = "loopstone: tracking",
          .message = std::string(to_string(estimate.state)),
          .values = {{"probability", fmt::format("{:.3f}", estimate.probability)}}};
}

}  // namespace loopstone
