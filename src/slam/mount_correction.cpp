#include "slam/mount_correction.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <utility>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

/// Times during which the two can't be compared.
std::vector<TimeSpan> not_comparable(const MapResult& result) {
  std::vector<TimeSpan> spans;
  for (const PathBreak& gap : result.breaks) spans.push_back({gap.from, gap.to});
  for (const LaserEpisode& episode : result.laser_episodes)
    spans.push_back({episode.from, episode.to});
  for (const OdometryEpisode& episode : result.odometry_episodes) {
    if (episode.fault == OdometryFault::kStuck || episode.fault == OdometryFault::kSpinning)
      spans.push_back({episode.from, episode.to});
  }
  return spans;
}

/// Motions between poses of the robot, told by another point of it.
class ByOtherCentre {
 public:
  /// \param new_T_old  of the two points
  explicit ByOtherCentre(const Pose2& new_T_old)
      : new_T_old_(new_T_old), old_T_new_(new_T_old.inverse()) {
    // An error (x, y, yaw) of the old motion is this one of the new.
    const Eigen::Vector2d arm = new_T_old.translation();
    error_.topLeftCorner<2, 2>() = new_T_old.rotation();
    error_.topRightCorner<2, 1>() << arm.y(), -arm.x();
  }

  /// Of a pose and of a motion alike, since the map's origin moves with the first pose.
  [[nodiscard]] Pose2 told(const Pose2& motion) const { return new_T_old_ * motion * old_T_new_; }
  [[nodiscard]] Eigen::Matrix3d covariance(const Eigen::Matrix3d& old) const {
    return error_ * old * error_.transpose();
  }
  [[nodiscard]] Eigen::Matrix3d information(const Eigen::Matrix3d& old) const {
    const Eigen::Matrix3d back = error_.inverse();
    const Eigen::Matrix3d told = back.transpose() * old * back;
    return 0.5 * (told + told.transpose());
  }

 private:
  Pose2 new_T_old_;
  Pose2 old_T_new_;
  Eigen::Matrix3d error_ = Eigen::Matrix3d::Identity();
};

std::string side_of(double yaw_rad) { return yaw_rad > 0.0 ? "left" : "right"; }

std::string yaw_words(const Calibration& calibration) {
  const double off = wrap_angle(calibration.lidar_yaw_rad.value - calibration.lidar_yaw_rad.given);
  return fmt::format("looks {:.2f} deg (+- {:.2f}) to the {} of where its mount says",
                     degrees(std::abs(off)), degrees(calibration.lidar_yaw_rad.sigma),
                     side_of(off));
}

std::string place_words(const Calibration& calibration) {
  const auto along = [](const CalibratedValue& value, const char* ahead, const char* behind) {
    const double off_mm = 1e3 * (value.value - value.given);
    return fmt::format("{:.0f} mm (+- {:.0f}) {}", std::abs(off_mm), 1e3 * value.sigma,
                       off_mm > 0.0 ? ahead : behind);
  };
  return "sits " + along(calibration.lidar_x_m, "ahead", "behind") + " and " +
         along(calibration.lidar_y_m, "to the left", "to the right") + " of where its mount says";
}

}  // namespace

AssumedMounts assumed_mounts(std::span<const SubmapRecord> submaps) {
  AssumedMounts mounts;
  for (const SubmapRecord& submap : submaps) {
    submap.scans.for_each([&](const MappedScan& mapped) {
      if (!mounts.first) {
        mounts.first = mapped.robot_T_lidar;
        mounts.lidar = mapped.scan.lidar;
        mounts.laser_is_centre = mapped.scan.robot_T_lidar && mapped.robot_T_lidar == Pose2{};
      }
      mounts.several = mounts.several || mounts.lidar != mapped.scan.lidar ||
                       !(mapped.robot_T_lidar == *mounts.first);
    });
  }
  return mounts;
}

Calibration calibrate_run(const std::deque<TrackedPose>& track, const AssumedMounts& mounts,
                          const MapResult& result) {
  if (!mounts.first) return {};
  Calibration calibration = calibrate(track, *mounts.first, not_comparable(result));
  calibration.lidar = mounts.lidar;
  calibration.several_mounts = mounts.several;
  calibration.is_corrected =
      calibration.mount_is_off() && !mounts.several && !mounts.laser_is_centre;
  return calibration;
}

void correct_mount(const Pose2& given, const Pose2& corrected, MapResult& result,
                   PlacedScans& placed) {
  const ByOtherCentre other(corrected * given.inverse());
  // In the old map the origin is the old first pose, wherever the graph has moved it.
  for (Pose2& pose : result.graph.poses) pose = other.told(pose);
  for (RelativePoseEdge& edge : result.graph.edges) {
    edge.from_T_to = other.told(edge.from_T_to);
    edge.information = other.information(edge.information);
  }
  for (LoopClosure& closure : result.loop_closures) {
    closure.from_T_to = other.told(closure.from_T_to);
    closure.covariance = other.covariance(closure.covariance);
  }
  Trajectory trajectory;
  trajectory.reserve(placed.trajectory.size());
  for (const StampedPose2& pose : placed.trajectory.poses())
    trajectory.append(pose.stamp, other.told(pose.pose));
  placed.trajectory = std::move(trajectory);
  const Pose2 new_map_T_map = corrected * given.inverse();
  const Pose2 lidar_T_robot = corrected.inverse();
  for (PosedScan& scan : placed.on_map) {
    scan.map_T_lidar = new_map_T_map * scan.map_T_lidar;
    scan.map_T_lidar_end = new_map_T_map * scan.map_T_lidar_end;
    scan.map_T_robot = scan.map_T_lidar * lidar_T_robot;
  }
}

std::vector<std::string> calibration_warnings(const MapResult& result) {
  const Calibration& calibration = result.calibration;
  if (!calibration.is_corrected) return {};
  std::string words = "the laser ";
  if (calibration.yaw_is_off) words += yaw_words(calibration);
  if (calibration.yaw_is_off && calibration.place_is_off) words += ", and ";
  if (calibration.place_is_off) words += place_words(calibration);
  return {words +
          ", as its motion beside odometry's tells: the path is corrected; `loopstone calibrate` "
          "writes a robot file that says so"};
}

}  // namespace loopstone
