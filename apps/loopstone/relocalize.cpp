#include "loopstone/localization/relocalize.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "commands.hpp"
#include "known_map.hpp"
#include "log_run.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/odometry/scan_queue.hpp"
#include "loopstone/sensor/mounted_scan.hpp"
#include "result.hpp"

namespace loopstone::app {

namespace {

struct Arguments {
  std::string log;
  std::string map;
  double at_s = 0.0;
  LogFlags reading;
};

constexpr const char* kFooter = R"(
Where on MAP the robot was when it took one scan of LOG, by that scan alone: all poses that explain it nearly as well as
the best, and how probable each is. "none of them" is the probability that the robot was elsewhere, or not on this map.
Places that look alike share the belief; `loopstone localize --global` tells them apart on the way.

explained      of the returns where the map knows what is there, the share that lies on a wall
through walls  of the beams, the share that went on behind a wall of the map
before walls   the share that ended well before one: people, things that are new

Examples:
  loopstone relocalize sim --map sim/map.yaml                      by the first scan
  loopstone relocalize drive.bag --map out --at 12.5 --json        by the first one from 12.5 s on)";

/// Of the robot at a scan [m/s, m/s, rad/s], where odometry tells it.
Tangent2 velocity_at(Stamp stamp, const Odometer& odometer) {
  constexpr double kSpanS = 0.1;
  const auto motion = odometer.motion_between(stamp - Duration::from_seconds(kSpanS), stamp);
  if (!motion) return Tangent2::Zero();
  return log(motion->pose) / kSpanS;
}

/// The first scan at --at or later.
TakenScan read_scan(const Arguments& arguments, const AppContext& context) {
  const auto reader = open_log(arguments.log, log_options(arguments.reading, context));
  tell_choices(*reader, context);
  const RobotModel robot = robot_of(*reader, context);
  ProgressDisplay display(context);
  CutLog log(*reader, {.start_s = arguments.at_s, .max_scans = 1}, !context.robot_given(),
             "reading", watch_by(display));
  ScanQueue queue(robot.wheels);
  while (const auto message = log.next()) {
    const auto mounted = as_mounted(*message, robot);
    queue.add(mounted ? *mounted : *message);
  }
  ProgressDisplay::clear_line();
  queue.finish();
  auto scan = queue.next();
  if (!scan) {
    throw DataError({arguments.log},
                    fmt::format("there is no laser scan in it from {:g} s on; `loopstone info` "
                                "shows how long it is",
                                arguments.at_s));
  }
  TakenScan taken{.robot_T_lidar = mount_of(*scan, robot),
                  .velocity = velocity_at(scan->stamp, queue.odometer())};
  taken.scan = std::move(*scan);
  return taken;
}

nlohmann::ordered_json json_of(const PlaceCandidate& candidate) {
  const Pose2& pose = candidate.map_T_robot;
  nlohmann::ordered_json covariance = nlohmann::ordered_json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      const double value = candidate.covariance(row, column);
      covariance.push_back(std::isfinite(value) ? nlohmann::ordered_json(value) : nullptr);
    }
  }
  return {{"map_T_robot", {{"x_m", pose.x}, {"y_m", pose.y}, {"yaw_rad", pose.yaw}}},
          {"covariance", std::move(covariance)},
          {"probability", candidate.probability},
          {"explained", candidate.fit.explained},
          {"violations", candidate.fit.violations},
          {"unexpected", candidate.fit.unexpected},
          {"known", candidate.fit.known},
          {"silent", candidate.fit.silent}};
}

void add_rows(const Relocalization& found, Result& result) {
  constexpr std::size_t kShown = 10;
  result.add_row("", fmt::format("{:>11}  {:>9}  {:>9}  {:>9}  {:>9}  {:>9}  {:>13}  {:>12}",
                                 "probability", "x [m]", "y [m]", "yaw [deg]", "sigma [m]",
                                 "explained", "through walls", "before walls"));
  for (std::size_t i = 0; i < std::min(kShown, found.candidates.size()); ++i) {
    const PlaceCandidate& candidate = found.candidates[i];
    const Pose2& pose = candidate.map_T_robot;
    const double sigma_m = std::sqrt(candidate.covariance(0, 0) + candidate.covariance(1, 1));
    result.add_row("", fmt::format("{:>11.3f}  {:>9.3f}  {:>9.3f}  {:>9.2f}  {:>9.3f}  {:>9.2f}  "
                                   "{:>13.2f}  {:>12.2f}",
                                   candidate.probability, pose.x, pose.y, degrees(pose.yaw),
                                   sigma_m, candidate.fit.explained, candidate.fit.violations,
                                   candidate.fit.unexpected));
  }
  if (found.candidates.size() > kShown) {
    result.add_row("", fmt::format("and {} less probable ones; --json lists all",
                                   found.candidates.size() - kShown));
  }
  result.add_row("", fmt::format("{:>11.3f}  none of them", found.none_probability));
}

ExitCode run(const Arguments& arguments, const AppContext& context) {
  using Clock = std::chrono::steady_clock;
  const LocalizationMap map = read_known_map(arguments.map, context.memory(), context.threads());
  const TakenScan scan = read_scan(arguments, context);
  const auto start = Clock::now();
  Relocalization found;
  try {
    found = relocalize(map, std::span(&scan, 1), context.threads());
  } catch (const UsageError& error) {  // of the scan: there is nothing to see in it
    throw DataError({arguments.log}, error.what());
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  Result result;
  result.add("stamp_s", "scan at", scan.scan.stamp.seconds(), "s", 3)
      .add("map_free_area_m2", "free area of the map", map.free_area_m2(), "m2", 1)
      .add("search_s", "found in", seconds, "s", 3)
      .add_json("none_probability", found.none_probability)
      .add_json("complete", found.complete);
  nlohmann::ordered_json candidates = nlohmann::ordered_json::array();
  for (const PlaceCandidate& candidate : found.candidates) candidates.push_back(json_of(candidate));
  result.add_json("candidates", std::move(candidates));
  add_rows(found, result);
  result.print(context);
  if (!found.complete)
    context.warn("more places look alike than were looked into; the true one may be left out");
  return kExitDone;
}

}  // namespace

void add_relocalize_command(CLI::App& app, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("relocalize", "Where on a known map one scan may have been taken");
  command
      ->add_option("LOG", arguments->log,
                   "a log file, or a folder (DIR#20 names set 20 of a UCSD folder)")
      ->required();
  command->add_option("--map", arguments->map, "a map.yaml, a folder that holds one, or a site")
      ->type_name("MAP")
      ->required();
  command
      ->add_option("--at", arguments->at_s,
                   "take the first scan from this time of the log on [s]; default: its first")
      ->type_name("SECONDS")
      ->check(CLI::NonNegativeNumber);
  add_log_flags(*command, arguments->reading);
  context.add_common_flags(*command);
  context.add_threads_flag(*command);
  context.add_robot_flag(*command);
  command->footer(kFooter);
  context.on_run(*command, [arguments, &context] { return run(*arguments, context); });
}

}  // namespace loopstone::app
