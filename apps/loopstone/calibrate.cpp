#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "commands.hpp"
#include "log_run.hpp"
#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "loopstone/formats/text_file.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/pipeline/log_calibration.hpp"
#include "output_path.hpp"
#include "progress_display.hpp"
#include "result.hpp"

namespace loopstone::app {

namespace {

struct Arguments {
  std::string log;
  std::string output;
  bool force = false;
  LogCut cut;
  LogFlags reading;
};

constexpr const char* kFooter = R"(
Compares the robot's motion as the laser tells it with that of odometry: wheel counts (with a gyro), or the poses
that the log holds. Told is what the log itself shows, with one standard deviation; what the robot's drive leaves
open is said to be so. With -o a robot file is written in which only that is changed which is certainly wrong.

Examples:
  loopstone calibrate LOG
  loopstone calibrate LOG -o robot.toml && loopstone map LOG -o out --robot robot.toml)";

/// One value, once for people and once for scripts.
void add_value(const std::string& key, const std::string& label, const CalibratedValue& value,
               double unit, const std::string& unit_name, int digits, Result& result) {
  const std::string given = fmt::format("given {:.{}f}", unit * value.given, digits);
  result.add_row(label, value.observable
                            ? fmt::format("{:.{}f} +- {:.{}f} {} ({})", unit * value.value, digits,
                                          unit * value.sigma, digits, unit_name, given)
                            : "not observable in this log (" + given + ")");
  result.add_json(key + ".value", value.value)
      .add_json(key + ".sigma", value.sigma)
      .add_json(key + ".given", value.given)
      .add_json(key + ".observable", value.observable);
}

void add_wheels(const WheelFindings& findings, const WheelModel& given, Result& result) {
  const double way = findings.found.translation_scale.value;
  const double way_sigma = findings.found.translation_scale.sigma;
  const double turn = findings.found.rotation_scale.value;
  const double turn_sigma = findings.found.rotation_scale.sigma;
  const bool way_known = findings.found.translation_scale.observable;
  add_value("wheels.metres_per_count", "way per count",
            {given.metres_per_count / way, given.metres_per_count * way_sigma / (way * way),
             given.metres_per_count, way_known},
            1e3, "mm", 5, result);
  const double track = given.track_width_m * turn / way;
  add_value("wheels.track_width_m", "track",
            {track, track * hypotenuse(turn_sigma / turn, way_sigma / way), given.track_width_m,
             way_known && findings.found.rotation_scale.observable},
            1e3, "mm", 1, result);
  add_value("wheels.turn_per_m_rad", "wheels turn going straight", findings.found.turn_per_m_rad,
            degrees(1.0), "deg/m", 4, result);
}

void print(const Calibration& c, const std::optional<WheelFindings>& wheels,
           const RobotModel& robot, const std::string& output, const AppContext& context) {
  Result result;
  result.add("motions", "motions compared", c.motions);
  add_value("lidar.x_m", "laser ahead of the centre", c.lidar_x_m, 1e3, "mm", 1, result);
  add_value("lidar.y_m", "laser left of it", c.lidar_y_m, 1e3, "mm", 1, result);
  add_value("lidar.yaw_rad", "laser looks left by", c.lidar_yaw_rad, degrees(1.0), "deg", 3,
            result);
  result.add("lidar.is_off", "laser's mount is wrong", c.mount_is_off());
  result.add("lidar.is_mirrored", "laser's beams go the other way", c.laser_is_mirrored);
  result.add("lidar.mirror_is_in_doubt", "or odometry turns the other way", c.mirror_is_in_doubt);
  add_value("lidar.sweep_s", "sweep that is not told", c.sweep_s, 1e3, "ms", 1, result);
  result.add("lidar.sweep_is_off", "sweep must be told", c.sweep_is_off);
  add_value("laser_delay_s", "scans later than stamped", c.laser_delay_s, 1e3, "ms", 1, result);
  add_value("odometry.translation_scale", "odometry's way / the laser's", c.translation_scale, 1.0,
            "", 4, result);
  add_value("odometry.rotation_scale", "odometry's turns / the laser's", c.rotation_scale, 1.0, "",
            4, result);
  add_value("odometry.turn_bias_rad_s", "odometry turns standing", c.turn_bias_rad_s, degrees(1.0),
            "deg/s", 4, result);
  add_value("odometry.turn_per_m_rad", "odometry turns going straight", c.turn_per_m_rad,
            degrees(1.0), "deg/m", 4, result);
  if (wheels) add_wheels(*wheels, robot.wheels, result);
  if (!output.empty()) result.add_row("robot file", output);
  result.print(context);
}

ExitCode run(const Arguments& arguments, const AppContext& context) {
  const auto options = context.load_options<MapOptions>();
  const LogFiles log_files(arguments.log);
  Outputs outputs(context, arguments.force);
  outputs.reads_log(arguments.log);
  if (!arguments.output.empty()) outputs.add_file("-o", arguments.output);
  outputs.check();
  ProblemPrinter print_problem(context);
  const LogSource source =
      source_of(arguments.log, log_options(arguments.reading, context, &print_problem), context);
  const auto reader = source.open();
  tell_choices(*reader, context);
  const RobotModel robot = context.robot_given() ? context.robot() : reader->robot(context.robot());
  outputs.prepare();

  ProgressDisplay display(context);
  const RobotFindings findings = calibrate_log(source, *reader, robot, arguments.cut, options,
                                               context.threads(), watch_by(display));
  ProgressDisplay::clear_line();
  for (const std::string& change : log_files.changes()) context.warn(change);
  require_findings(findings, arguments.log);
  if (!arguments.output.empty())
    write_text_file(arguments.output, robot_to_toml(findings.corrected));
  print(findings.map.calibration, findings.wheels, findings.given, arguments.output, context);
  return kExitDone;
}

}  // namespace

void add_calibrate_command(CLI::App& app, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "calibrate", "How the laser sits and the wheels count, by the robot's own motion");
  command->add_option("LOG", arguments->log, "a log file or folder")->required();
  command
      ->add_option("-o,--output", arguments->output,
                   "also the robot as a file for --robot, with what is certainly wrong put right")
      ->type_name("FILE.toml");
  add_cut_flags(*command, arguments->cut);
  add_log_flags(*command, arguments->reading);
  add_force_flag(*command, arguments->force);
  context.add_robot_flag(*command);
  context.add_option_flags(*command);
  context.add_threads_flag(*command);
  context.add_common_flags(*command);
  command->footer(kFooter);
  context.on_run(*command, [arguments, &context] { return run(*arguments, context); });
}

}  // namespace loopstone::app
