#include "loopstone/pipeline/log_calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/odometry/dead_reckoning.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/slam/robot_correction.hpp"

namespace loopstone {

namespace {

constexpr double kHarmless = 0.001;

/// What a robot file may be changed for.
bool is_wrong(const CalibratedValue& value) {
  return value.observable &&
         std::abs(value.value - value.given) > std::max(3.0 * value.sigma, kHarmless);
}

std::optional<WheelFindings> judge_wheels(const DeadReckoningResult& by_wheels,
                                          const MapResult& map, const WheelModel& wheels) {
  if (by_wheels.wheel_readings == 0 || map.calibration.motions == 0) return {};
  std::deque<TrackedPose> track;
  for (const StampedPose2& pose : map.trajectory.poses())
    track.push_back({pose.stamp, pose.pose, by_wheels.trajectory.nearest(pose.stamp, Duration{})});
  WheelFindings findings{calibrate(track, map.calibration.robot_T_lidar()), wheels};
  const CalibratedValue& way = findings.found.translation_scale;
  const CalibratedValue& turn = findings.found.rotation_scale;
  if (is_wrong(way)) findings.wheels.metres_per_count /= way.value;
  if (way.observable && is_wrong(turn))
    findings.wheels.track_width_m *= turn.value / (is_wrong(way) ? way.value : 1.0);
  return findings;
}

/// The robot with what is certainly wrong put right.
RobotModel corrected(const RobotFindings& findings) {
  RobotModel robot = findings.given;
  const Calibration& calibration = findings.map.calibration;
  if (findings.mount_corrected()) {
    const auto index = static_cast<std::size_t>(std::max(calibration.lidar, 0));
    if (robot.lidars.size() <= index) robot.lidars.resize(index + 1);
    robot.lidars[index].robot_T_lidar = calibration.robot_T_lidar();
  }
  if (findings.wheels) robot.wheels = findings.wheels->wheels;
  // Wheels that count right need no scale.
  const double scale = calibration.odometry_scale;
  const bool is_off = scale > 0.0 && std::abs(scale - 1.0) > kHarmless;
  robot.odometry_scale = is_off && !findings.wheels ? scale : 1.0;
  return robot;
}

/// One reading of the log.
struct Reading {
  MapResult map{};
  DeadReckoningResult by_wheels{};
};

Reading read(CutLog& log, const RobotModel& robot, const MapOptions& options, Threads threads) {
  Mapper mapper(robot, options, threads);
  DeadReckoner by_wheels(robot.wheels, {.yaw = YawSource::kWheels});
  while (const auto message = log.next()) {
    by_wheels.add(*message);
    mapper.add(*message);
    while (mapper.next_update()) {
    }
  }
  return {mapper.finish(), by_wheels.finish()};
}

std::vector<std::string> words_on(const RobotFindings& findings) {
  const Calibration& found = findings.map.calibration;
  const std::string end =
      ", as its driving tells: taken to be so; `loopstone calibrate -o` writes a robot file";
  std::vector<std::string> words;
  if (findings.mount_is_certain()) {
    words.push_back(fmt::format(
        "the laser sits at ({:.3f}, {:.3f}) m and looks {:.2f} deg to the left, not at ({:.3f}, "
        "{:.3f}) m and {:.2f} deg{}",
        found.lidar_x_m.value, found.lidar_y_m.value, degrees(found.lidar_yaw_rad.value),
        found.lidar_x_m.given, found.lidar_y_m.given, degrees(found.lidar_yaw_rad.given), end));
  }
  if (found.sweep_is_off) {
    words.push_back(fmt::format("the beams of a scan leave over {:.0f} ms, not at once{}",
                                1e3 * found.sweep_s.value, end));
  }
  if (found.laser_is_mirrored) words.push_back("the laser hangs upside down" + end);
  return words;
}

}  // namespace

RobotFindings calibrate_log(const LogSource& source, LogReader& reader, const RobotModel& robot,
                            const LogCut& cut, MapOptions options, Threads threads,
                            const ReadingWatch& watch) {
  options.calibration = true;
  // The robot's motion over a second needs no closed loops.
  options.loop_closure = options.adjustment.enabled = false;
  RobotFindings findings{.given = robot};
  CutLog log(reader, cut, source.mounts_from_log(), "calibrating", watch);
  Reading result = read(log, robot, options, threads);
  findings.log = log.judge(source.path);
  findings.interrupted = log.interrupted();
  Calibration found;
  for (int anew = 0; anew < kMostMadeAnew && result.map.calibration.map_is_bent(); ++anew) {
    if (findings.interrupted) break;
    // Once more with beams as they are. All else follows from them.
    found = beside(found, result.map.calibration);
    findings.given = corrected_robot(robot, found);
    const auto again = source.open_again();
    CutLog second(*again, cut, source.mounts_from_log(), "calibrating anew", watch);
    result = read(second, findings.given, options, threads);
    findings.interrupted = second.interrupted();
  }
  if (found.map_is_bent()) tell_of_correction(found, result.map);
  findings.wheels = judge_wheels(result.by_wheels, result.map, findings.given.wheels);
  findings.map = std::move(result.map);
  findings.corrected = corrected(findings);
  return findings;
}

void require_findings(const RobotFindings& findings, const std::string& path) {
  if (findings.map.calibration.motions > 0) return;
  throw DataError({path},
                  "too little to calibrate by: it takes odometry that agrees with the laser, and "
                  "half a minute of driving");
}

DrivenRobot robot_as_driven(const LogSource& source, const RobotModel& told, LogCut cut,
                            Threads threads, const ReadingWatch& watch) {
  constexpr double kEnoughS = 300.0;
  if (source.robot) return {.model = told, .mounts_from_log = false};
  cut.duration_s = cut.duration_s > 0.0 ? std::min(cut.duration_s, kEnoughS) : kEnoughS;
  const auto reader = source.open_again();
  const RobotFindings findings =
      calibrate_log(source, *reader, told, cut, MapOptions{}, threads, watch);
  return {.model = findings.mount_is_certain() ? findings.corrected : findings.given,
          .mounts_from_log = !findings.mount_is_certain(),
          .warnings = words_on(findings)};
}

}  // namespace loopstone
