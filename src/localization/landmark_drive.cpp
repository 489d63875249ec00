#include "loopstone/localization/landmark_drive.hpp"

#include "localization/robot_motion.hpp"
#include "loopstone/odometry/odometer.hpp"
#include "slam/scan_edges.hpp"

namespace loopstone {
namespace {

/// Of a step, beside what odometry says of itself: what slips is not independent from step to step.
constexpr double kStrayM = 0.001;
constexpr double kStrayRad = 0.0005;
/// What odometry forgets soon is taken over as often as this.
constexpr Duration kTakenOver = Duration::from_milliseconds(1000);

/// The motion from reading to reading.
class Way {
 public:
  explicit Way(std::span<const OdometryPose> odometry) : odometry_(odometry) {}

  PoseWithCovariance2 to(Stamp stamp) {
    PoseWithCovariance2 way;
    while (next_ < odometry_.size() && !is_known_until(stamp)) {
      odometer_.add(odometry_[next_++]);
      const auto until = odometer_.newest();
      if (until && *until < stamp && motion_.last_stamp() &&
          *until >= *motion_.last_stamp() + kTakenOver)
        way = compound(way, motion_.step_to(*until, odometer_));
    }
    if (next_ == odometry_.size()) odometer_.finish();
    way = compound(way, motion_.step_to(stamp, odometer_));
    way.covariance += planar_covariance(kStrayM, kStrayRad);
    return way;
  }
  [[nodiscard]] bool had_odometry() const { return motion_.had_odometry(); }

 private:
  [[nodiscard]] bool is_known_until(Stamp stamp) const {
    return odometer_.newest() && *odometer_.newest() >= stamp;
  }

  std::span<const OdometryPose> odometry_;
  std::size_t next_ = 0;
  Odometer odometer_{WheelModel{}};
  RobotMotion motion_{LocalizationOptions{}};
};

}  // namespace

LandmarkDrive drive_among_landmarks(std::span<const OdometryPose> odometry,
                                    std::span<const LandmarkReading> readings) {
  LandmarkDrive drive;
  Way way(odometry);
  for (const LandmarkReading& reading : readings) {
    if (reading.observations.empty()) continue;
    if (!drive.stamps.empty() && reading.stamp <= drive.stamps.back()) continue;
    const PoseWithCovariance2 step = way.to(reading.stamp);
    const int node = static_cast<int>(drive.graph.poses.size());
    if (node == 0) {
      drive.graph.poses.emplace_back();
    } else {
      drive.graph.poses.push_back(drive.graph.poses.back() * step.pose);
      drive.graph.edges.push_back(edge_between(node - 1, node, step, EdgeKind::kOdometry));
    }
    drive.stamps.push_back(reading.stamp);
    drive.seen.push_back(reading.observations);
  }
  drive.had_odometry = way.had_odometry();
  return drive;
}

LandmarkDriveMap map_drive(const LandmarkDrive& drive, const LandmarkMappingOptions& options) {
  LandmarkDriveMap map;
  map.mapping = map_landmarks(drive.graph, drive.seen, options);
  const std::vector<Pose2>& poses = map.mapping.graph.poses;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    map.trajectory.append(drive.stamps[i], poses[i]);
    map.odometry.append(drive.stamps[i], drive.graph.poses[i]);
    if (i > 0) map.path_length_m += (poses[i].translation() - poses[i - 1].translation()).norm();
  }
  if (!drive.stamps.empty())
    map.duration_s = (drive.stamps.back() - drive.stamps.front()).seconds();
  if (!drive.had_odometry) {
    map.warnings.emplace_back(
        "the log has no odometry: the robot is assumed to keep its velocity from reading to "
        "reading");
  }
  if (map.mapping.landmarks.empty()) {
    map.warnings.emplace_back(
        "no landmarks: nothing was seen often enough, from places far enough apart; see "
        "landmarks.sightings_min and landmarks.baseline_min_m");
  }
  return map;
}

}  // namespace loopstone
