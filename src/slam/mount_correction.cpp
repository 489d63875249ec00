#include "slam/mount_correction.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <utility>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/odometry/odometry_accuracy.hpp"
#include "slam/path_drift.hpp"
#include "slam/run_clock.hpp"
#include "slam/sensor_faults.hpp"
#include "slam/sweep_fit.hpp"
#include "slam/turning_beams.hpp"

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
  const Pose2 new_T_old = corrected * given.inverse();
  const ByOtherCentre other(new_T_old);
  // In the old map the origin is the old first pose, wherever the graph has moved it.
  for (Pose2& pose : result.graph.poses) pose = other.told(pose);
  for (RelativePoseEdge& edge : result.graph.edges) {
    edge.from_T_to = other.told(edge.from_T_to);
    edge.information = other.information(edge.information);
  }
  for (Eigen::Vector2d& landmark : result.graph.landmarks) landmark = new_T_old * landmark;
  const Eigen::Matrix2d new_R_old = new_T_old.rotation();
  for (LandmarkEdge& edge : result.graph.landmark_edges) {
    edge.point_in_from = new_T_old * edge.point_in_from;
    edge.information = new_R_old * edge.information * new_R_old.transpose();
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
  const Pose2 lidar_T_robot = corrected.inverse();
  for (PosedScan& scan : placed.on_map) {
    scan.map_T_lidar = new_T_old * scan.map_T_lidar;
    scan.map_T_lidar_end = new_T_old * scan.map_T_lidar_end;
    scan.map_T_robot = scan.map_T_lidar * lidar_T_robot;
  }
}

namespace {

/// By what scans show, all along the drive: odometry may turn the other way for a while.
bool beams_go_opposite(const std::deque<TrackedPose>& track, int lidar,
                       std::span<const SubmapRecord> submaps) {
  const TurnVotes votes = turn_votes(submaps, track, lidar);
  return votes.are_opposite() &&
         (votes.are_all_along(track.back().stamp - track.front().stamp) || !turns_agree(track));
}

}  // namespace

void judge_beams(const std::deque<TrackedPose>& track, const AssumedMounts& mounts,
                 std::span<const SubmapRecord> submaps, MapResult& result) {
  if (!mounts.first || mounts.several) return;
  Calibration& calibration = result.calibration;
  calibration.lidar = mounts.lidar;
  calibration.turns_opposite =
      calibration.turns_opposite || beams_go_opposite(track, mounts.lidar, submaps);
  // A base that counts its turns backwards can't be driven by anybody; a laser upside down can.
  const std::optional<double>& with_gyro = result.statistics.wheels_with_gyro;
  calibration.laser_is_mirrored =
      calibration.turns_opposite && (with_gyro ? *with_gyro > kSensorFaults.same_correlation
                                               : result.statistics.odometry_is_told);
  calibration.mirror_is_in_doubt = calibration.laser_is_mirrored && !with_gyro;
  const auto fit = fit_sweep(untold_scans(submaps, track, mounts.lidar));
  if (!fit) return;
  calibration.sweep_s = {fit->sweep_s, fit->sigma_s, 0.0, fit->is_known()};
  calibration.sweep_is_off = fit->is_off();
}

void judge_scale(std::span<const KeyScan> keys, const std::deque<TrackedPose>& track,
                 double assumed_scale, MapResult& result) {
  const double scale = result.statistics.odometry_translation_scale;
  if (!(scale > 0.0)) return;
  Calibration& calibration = result.calibration;
  calibration.odometry_scale = scale;
  calibration.open_travel_error_m = open_travel_error_m(keys, {track, scale, result.breaks});
  const bool is_new = assumed_scale == 1.0 && std::abs(scale - 1.0) > kCalibration.scale_least_off;
  calibration.scale_is_off =
      is_new && std::abs(calibration.open_travel_error_m) > kCalibration.open_travel_harmless_m;
}

bool scale_is_known(const Calibration& calibration) {
  return calibration.odometry_scale > 0.0 &&
         (!calibration.scale_is_off || calibration.scale_corrected);
}

double scale_sigma(const Calibration& calibration) {
  return scale_is_known(calibration) ? kCalibration.scale_sigma : kOdometryAccuracy.least_share;
}

namespace {

std::string end_of(bool corrected) {
  return corrected
             ? "the map was made anew with that; `loopstone calibrate` writes a robot file that "
               "says so"
             : "the map must be made anew with that";
}

}  // namespace

std::vector<std::string> correction_warnings(const Calibration& calibration) {
  const std::string end = end_of(calibration.beams_corrected);
  std::vector<std::string> warnings;
  if (calibration.laser_is_mirrored) {
    warnings.push_back(
        (calibration.mirror_is_in_doubt
             ? "the laser turns the other way than odometry, all along: taken for a laser that "
               "hangs upside down, or whose beams are listed in the wrong order, as it mostly is; "
               "if it is odometry's heading that has the wrong sign, the map is a mirror image "
               "(--no-calibration maps the laser as it is); "
             : "the laser turns the other way than odometry and gyro, which agree with one "
               "another: it hangs upside down, or its beams are listed in the wrong order; ") +
        end);
  }
  if (calibration.scale_is_off) {
    warnings.push_back(fmt::format(
        "odometry's way is {:.1f} % too {}, as the laser tells where it can: bare corridors that "
        "were driven before that was known are {} too {}; {}",
        100.0 * std::abs(calibration.odometry_scale - 1.0),
        calibration.odometry_scale > 1.0 ? "long" : "short",
        readable_metres(std::abs(calibration.open_travel_error_m)),
        calibration.open_travel_error_m > 0.0 ? "long" : "short",
        end_of(calibration.scale_corrected)));
  }
  if (calibration.sweep_is_off) {
    const CalibratedValue& sweep = calibration.sweep_s;
    warnings.push_back(fmt::format(
        "the beams of a scan leave over {:.1f} ms (+- {:.1f}){}, as the scans of a robot "
        "that turns tell: the log says that they leave at once; {}",
        1e3 * std::abs(sweep.value), 1e3 * sweep.sigma,
        sweep.value > 0.0 ? "" : ", the last one first", end));
  }
  return warnings;
}

std::vector<std::string> calibration_warnings(const MapResult& result) {
  const Calibration& calibration = result.calibration;
  std::vector<std::string> warnings = correction_warnings(calibration);
  if (!calibration.is_corrected) return warnings;
  std::string words = "the laser ";
  if (calibration.yaw_is_off) words += yaw_words(calibration);
  if (calibration.yaw_is_off && calibration.place_is_off) words += ", and ";
  if (calibration.place_is_off) words += place_words(calibration);
  warnings.push_back(
      words +
      ", as its motion beside odometry's tells: the path is corrected; `loopstone calibrate` "
      "writes a robot file that says so");
  return warnings;
}

}  // namespace loopstone
