#include <fmt/format.h>

#include <memory>

#include "commands.hpp"
#include "interrupt.hpp"
#include "log_run.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/odometry/dead_reckoning.hpp"
#include "output_path.hpp"
#include "progress_display.hpp"
#include "result.hpp"
#include "word_flag.hpp"

namespace loopstone::app {

namespace {

struct Arguments {
  std::string log;
  std::string output;
  bool euler = false;
  std::optional<YawSource> yaw;
  std::optional<StampAlignment> align;
  bool force = false;
  LogFlags reading;
};

constexpr const char* kFooter = R"(
Writes odom_T_robot for every scan, or for every wheel reading when the log has no scans, in TUM format
(t x y z qx qy qz qw). Wheel counts are used if the log has any, else the odometry poses that it holds.

Examples:
  loopstone odometry intel.clf -o odometry.tum
  loopstone odometry ucsd/sensors#20 -o odometry.tum --yaw wheels --euler)";

OdometryOptions options_of(const Arguments& arguments, const AppContext& context) {
  auto options = context.load_options<OdometryOptions>();
  if (arguments.euler) options.integration = StepShape::kEuler;
  options.yaw = arguments.yaw.value_or(options.yaw);
  options.alignment = arguments.align.value_or(options.alignment);
  return options;
}

void print(const DeadReckoningResult& dead_reckoning, const LogReader& log, bool interrupted,
           const AppContext& context) {
  const Trajectory& trajectory = dead_reckoning.trajectory;
  const Pose2& last = trajectory.back().pose;
  Result result;
  result.add("poses", "poses written", trajectory.size())
      .add("duration_s", "duration", (trajectory.back().stamp - trajectory.front().stamp).seconds(),
           "s", 1)
      .add("path_length_m", "path", trajectory.path_length_m(), "m", 2)
      .add_row("last pose",
               fmt::format("{:.3f} m, {:.3f} m, {:.2f} deg", last.x, last.y, degrees(last.yaw)))
      .add_json("last_pose.x_m", last.x)
      .add_json("last_pose.y_m", last.y)
      .add_json("last_pose.yaw_rad", last.yaw)
      .add("scans", "scans", dead_reckoning.scans)
      .add("scans_without_pose", "scans without a pose", dead_reckoning.scans_without_pose)
      .add("wheel_readings", "wheel readings", dead_reckoning.wheel_readings)
      .add("odometry_poses", "odometry poses in the log", dead_reckoning.odometry_poses)
      .add("gyro_samples", "gyro samples", dead_reckoning.gyro_samples)
      .add("readings_turned_by_gyro", "readings turned by the gyro", dead_reckoning.turned_by_gyro)
      .add("gyro_bias_rad_s", "gyro bias", dead_reckoning.gyro_bias_rad_s, "rad/s", 5)
      .add("records_skipped", "records skipped", log.records_skipped())
      .add("complete", "complete", !interrupted);
  result.print(context);
}

/// False when the user interrupted.
bool read_log(LogReader& log, DeadReckoner& reckoner, LeftOutCounter& counter,
              ProgressDisplay& display) {
  std::int64_t messages = 0;
  while (const auto message = log.next()) {
    reckoner.add(*message);
    counter.add(*message);
    const ReadProgress read = log.progress();
    if (++messages % 256 == 0 &&
        !display.show({"dead reckoning", read.bytes_done, read.bytes_total}))
      return false;
  }
  return !interrupted();
}

ExitCode run(const Arguments& arguments, AppContext& context) {
  const OdometryOptions options = options_of(arguments, context);
  const LogFiles log_files(arguments.log);
  Outputs outputs(context, arguments.force);
  outputs.reads_log(arguments.log);
  outputs.add_file("-o", arguments.output);
  outputs.check(least_bytes_of_results(log_files.bytes()));
  const auto log = open_log(arguments.log, log_options(arguments.reading, context));
  tell_choices(*log, context);
  const RobotModel robot = robot_of(*log, context);
  outputs.prepare();

  const HeldInterrupt held;
  DeadReckoner reckoner(robot.wheels, options);
  ProgressDisplay display(context);
  LeftOutCounter counter(*log);
  const bool go_on = read_log(*log, reckoner, counter, display);
  if (go_on) judge_left_out(counter.left_out(), arguments.log, context);
  const DeadReckoningResult dead_reckoning = reckoner.finish();
  if (dead_reckoning.trajectory.empty() && !go_on) {
    context.warn("interrupted before the first pose: nothing was written");
    return kExitInterrupted;
  }
  if (dead_reckoning.trajectory.empty()) {
    throw DataError({arguments.log},
                    "no odometry: the log has neither wheel counts nor odometry poses near its "
                    "scans (`loopstone info` lists what it has)");
  }
  if (arguments.yaw == YawSource::kGyro && dead_reckoning.turned_by_gyro == 0) {
    context.warn(
        "the log has no usable gyro; the heading comes from " +
        std::string(dead_reckoning.wheel_readings > 0 ? "the wheels" : "its own odometry"));
  }
  write_tum(arguments.output, dead_reckoning.trajectory);
  warn_of_changes(log_files, context);
  print(dead_reckoning, *log, !go_on, context);
  if (!go_on) context.warn("interrupted: the poses are those until then");
  return go_on ? kExitDone : kExitInterrupted;
}

}  // namespace

void add_odometry_command(CLI::App& app, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("odometry", "Dead reckoning from wheels and gyro alone");
  command->add_option("LOG", arguments->log, "a log file or folder")->required();
  command->add_option("-o,--output", arguments->output, "the trajectory to write")
      ->type_name("FILE.tum")
      ->required();
  command->add_flag("--euler", arguments->euler,
                    "straight steps as in textbooks instead of exact arcs");
  add_word_flag(*command, "--yaw", arguments->yaw,
                "where the heading comes from (default: gyro where there is one)");
  add_word_flag(*command, "--align", arguments->align,
                "how readings with different stamps are brought together (default: interpolate)");
  add_log_flags(*command, arguments->reading);
  add_force_flag(*command, arguments->force);
  context.add_robot_flag(*command);
  context.add_option_flags(*command);
  context.add_common_flags(*command);
  command->footer(kFooter);
  context.on_run(*command, [arguments, &context] { return run(*arguments, context); });
}

}  // namespace loopstone::app
