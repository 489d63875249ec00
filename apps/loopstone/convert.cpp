#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "commands.hpp"
#include "interrupt.hpp"
#include "log_run.hpp"
#include "loopstone/formats/convert_log.hpp"
#include "loopstone/formats/log_files.hpp"
#include "loopstone/formats/log_format_words.hpp"
#include "loopstone/formats/output_place.hpp"
#include "output_path.hpp"
#include "progress_display.hpp"
#include "result.hpp"

namespace loopstone::app {

namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string input;
  std::string output;
  std::optional<std::string> format;
  bool force = false;
  LogFlags reading;
};

std::string footer() {
  std::string meanings;
  for (const std::string& meaning : log_name_meanings()) meanings += "  " + meaning + "\n";
  return fmt::format(R"(
The format of OUT follows from its name:
{}What the new format can't hold is said on stderr; `loopstone info --formats` tells it before.

Examples:
  loopstone convert intel.clf intel_ucsd#1
  loopstone convert data/ucsd#20 set20.clf.gz --robot robot.toml)",
                     meanings);
}

Outputs outputs_of(const LogTarget& target, const Arguments& arguments, const AppContext& context) {
  Outputs outputs(context, arguments.force);
  // Another set may be written into the folder that is read.
  for (const std::string& path : LogFiles(arguments.input).paths()) outputs.reads(path);
  const bool in_new_folder = target.format->place == LogPlace::kFolder;
  for (const std::string& path : log_parts(target).files) {
    outputs.add_file("", path, in_new_folder);
  }
  return outputs;
}

/// What a run that was killed left in the folder of a log.
void remove_unfinished(const LogTarget& target) {
  if (target.format->place == LogPlace::kFile) return;
  std::set<fs::path> folders{target.path};
  for (const std::string& folder : log_parts(target).folders) {
    folders.insert(fs::path(folder).parent_path());
  }
  for (const fs::path& folder : folders) remove_partial_files(folder.string());
}

void print(const Arguments& arguments, const LogTarget& target, const ConvertResult& converted,
           const std::vector<std::string>& notes, const AppContext& context) {
  Result result;
  result.add("output", "written", arguments.output)
      .add("format", "format", std::string(target.format->name))
      .add("scans", "scans", converted.scans)
      .add("odometry_poses", "odometry poses", converted.odometry_poses)
      .add("wheel_readings", "wheel readings", converted.wheel_readings)
      .add("inertial_readings", "inertial readings", converted.inertial_readings)
      .add("camera_frames", "camera frames", converted.camera_frames)
      .add("poses_by_dead_reckoning", "poses by dead reckoning", converted.poses_by_dead_reckoning)
      .add("records_skipped", "records skipped", converted.left_out.skipped.records)
      .add_json("notes", notes);
  result.print(context);
}

/// No log says what its wheel counts mean: whoever reads the new one has to.
void tell_wheels(const LogReader& log, const AppContext& context) {
  const WheelModel asked = context.robot().wheels;
  const WheelModel own = log.wheels(asked);
  if (own.metres_per_count == asked.metres_per_count && own.track_width_m == asked.track_width_m) {
    return;
  }
  context.warn(
      fmt::format("the wheel counts that were written are of {:.9g} m each, with a track of {:.6g} "
                  "m: say metres_per_count and track_width_m by --robot FILE when you read them",
                  own.metres_per_count, own.track_width_m));
}

ExitCode run(const Arguments& arguments, AppContext& context) {
  const LogTarget target = log_target(arguments.output, arguments.format);
  const LogFiles log_files(arguments.input);
  const Outputs outputs = outputs_of(target, arguments, context);
  outputs.check(least_bytes_of_results(log_files.bytes()));
  LogOptions options = log_options(arguments.reading, context);
  options.intensities = target.format->holds.intensities;
  const auto log = open_log(arguments.input, options);
  tell_choices(*log, context);
  const RobotModel robot = robot_of(*log, context);
  const HeldInterrupt held;  // the writer removes what it began
  outputs.prepare();
  remove_unfinished(target);
  const auto writer = create_log(target, robot);
  writer->use_pictures(log->pictures());
  ProgressDisplay display(context);
  const ConvertResult converted =
      convert_log(*log, *writer, target.format->holds, robot, display.callback());
  ProgressDisplay::clear_line();
  if (!converted.complete) {
    context.warn("interrupted: nothing was written");
    return kExitInterrupted;
  }
  judge_left_out(converted.left_out, arguments.input, context, Severity::kNote);
  writer->finish();
  warn_of_changes(log_files, context);
  for (const std::string& note : writer->notes()) context.warn(note);
  if (target.format->holds.wheel_ticks && converted.wheel_readings > 0) {
    tell_wheels(*log, context);
  }
  print(arguments, target, converted, writer->notes(), context);
  return kExitDone;
}

}  // namespace

void add_convert_command(CLI::App& app, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("convert", "Write a log in another format");
  command->add_option("IN", arguments->input, "a log file or folder")->required();
  command->add_option("OUT", arguments->output, "the log to write")->required();
  add_format_flag(*command, arguments->format, "of OUT (default: by its name)");
  command->add_flag("--force", arguments->force, "overwrite OUT");
  arguments->reading.pictures = true;
  add_log_flags(*command, arguments->reading);
  context.add_robot_flag(*command);
  context.add_common_flags(*command);
  command->footer(footer());
  context.on_run(*command, [arguments, &context] { return run(*arguments, context); });
}

}  // namespace loopstone::app
