#include "log_calibration.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <utility>

#include "interrupt.hpp"
#include "loopstone/odometry/dead_reckoning.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/slam/robot_correction.hpp"

namespace loopstone::app {

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
  const HeldInterrupt held;
  MapResult map = mapper.finish();
  ProgressDisplay::clear_line();
  return {std::move(map), by_wheels.finish()};
}

}  // namespace

RobotFindings calibrate_log(const std::string& path, LogReader& reader, const RobotModel& robot,
                            const LogCut& cut, const LogFlags& reading, MapOptions options,
                            ProgressDisplay& display, const AppContext& context) {
  options.calibration = true;
  // The robot's motion over a second needs no closed loops.
  options.loop_closure = options.adjustment.enabled = false;
  RobotFindings findings{.given = robot};
  CutLog log(reader, cut, !context.robot_given(), "calibrating", display);
  Reading result = read(log, robot, options, context.threads());
  findings.log = log.judge(path);
  findings.interrupted = log.interrupted();
  const Calibration first = result.map.calibration;
  if (first.map_is_bent() && !findings.interrupted) {
    // Once more with beams as they are. All else follows from them.
    findings.given = corrected_robot(findings.given, first);
    const auto again = open_log(path, log_options(reading, context));
    CutLog second(*again, cut, !context.robot_given(), "calibrating anew", display);
    result = read(second, findings.given, options, context.threads());
    findings.interrupted = second.interrupted();
    tell_of_correction(first, result.map);
  }
  findings.wheels = judge_wheels(result.by_wheels, result.map, findings.given.wheels);
  findings.map = std::move(result.map);
  findings.corrected = corrected(findings);
  return findings;
}

}  // namespace loopstone::app
