#include <fmt/format.h>

#include <filesystem>
#include <initializer_list>
#include <memory>

#include "commands.hpp"
#include "interrupt.hpp"
#include "log_run.hpp"
#include "loopstone/formats/convert_log.hpp"
#include "loopstone/formats/log_files.hpp"
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
  std::string format;
  bool force = false;
  bool strict = false;
};

constexpr const char* kFooter = R"(
The format of OUT follows from its name: .clf and .log, also with .gz or .bz2, are CARMEN text; a folder is the UCSD
layout, FOLDER#21 its set 21 (20 without a number). What the new format can't hold is said on stderr.

Examples:
  loopstone convert intel.clf intel_ucsd#1
  loopstone convert data/ucsd#20 set20.clf.gz --robot robot.toml)";

struct Target {
  std::string path;
  std::string format;
  int set = 20;
};

bool is_carmen_name(std::string name) {
  for (const char* const packed : {".gz", ".bz2"}) {
    if (name.ends_with(packed)) name.erase(name.rfind('.'));
  }
  return name.ends_with(".clf") || name.ends_with(".log") || name.ends_with(".carmen");
}

Target target_of(const Arguments& arguments) {
  Target target{arguments.output, arguments.format};
  if (target.format.empty()) target.format = is_carmen_name(target.path) ? "carmen" : "ucsd";
  const std::size_t hash = target.path.rfind('#');
  if (target.format == "ucsd" && hash != target.path.npos) {
    const std::string digits = target.path.substr(hash + 1);
    const bool is_number = !digits.empty() && digits.size() <= 6 &&
                           digits.find_first_not_of("0123456789") == digits.npos;
    if (!is_number) {
      throw UsageError("'" + target.path + "': after '#' the number of a set was expected");
    }
    target.set = std::stoi(digits);
    target.path.erase(hash);
  }
  if (target.format == "ucsd" && fs::path(target.path).has_extension() &&
      arguments.format.empty() && !fs::is_directory(target.path)) {
    throw UsageError("'" + target.path +
                     "': the format does not follow from this name; write to a .clf file or a "
                     "folder, or say --format carmen or --format ucsd");
  }
  return target;
}

Outputs outputs_of(const Target& target, const Arguments& arguments, const AppContext& context) {
  Outputs outputs(context, arguments.force);
  // Another set may be written into the folder that is read.
  for (const std::string& path : LogFiles(arguments.input).paths()) outputs.reads(path);
  if (target.format == "carmen") {
    outputs.add_file("", target.path);
    return outputs;
  }
  for (const char* const sensor : {"Encoders", "Imu", "Hokuyo", "Kinect", "Odometry"}) {
    outputs.add_file("", fs::path(target.path) / fmt::format("{}{}.npz", sensor, target.set), true);
  }
  return outputs;
}

/// What a run that was killed left of a set: its npz files are made of others.
void remove_unfinished_set(const Target& target) {
  if (target.format == "carmen") return;
  remove_partial_files(target.path);
  remove_partial_files((fs::path(target.path) / "dataRGBD").string());
}

ExitCode run(const Arguments& arguments, AppContext& context) {
  const Target target = target_of(arguments);
  const LogFiles log_files(arguments.input);
  const Outputs outputs = outputs_of(target, arguments, context);
  outputs.check(least_bytes_of_results(log_files.bytes()));
  const auto log = open_log(arguments.input, log_options(arguments.strict, context));
  const RobotModel robot = context.robot_given() ? context.robot() : log->robot(context.robot());
  const HeldInterrupt held;  // the writer removes what it began
  outputs.prepare();
  remove_unfinished_set(target);
  const auto writer = create_log(target.path, target.format, robot, target.set);
  ProgressDisplay display(context);
  const ConvertResult converted = convert_log(
      *log, *writer, robot, {.wheels_to_poses = target.format == "carmen"}, display.callback());
  ProgressDisplay::clear_line();
  if (!converted.complete) {
    context.warn("interrupted: nothing was written");
    return kExitInterrupted;
  }
  judge_left_out(converted.left_out, arguments.input, context, Severity::kNote);
  writer->finish();
  warn_of_changes(log_files, context);
  for (const std::string& note : writer->notes()) context.warn(note);
  Result result;
  result.add("output", "written", arguments.output)
      .add("format", "format", target.format)
      .add("scans", "scans", converted.scans)
      .add("odometry_poses", "odometry poses", converted.odometry_poses)
      .add("wheel_readings", "wheel readings", converted.wheel_readings)
      .add("inertial_readings", "inertial readings", converted.inertial_readings)
      .add("camera_frames", "camera frames", converted.camera_frames)
      .add("poses_by_dead_reckoning", "poses by dead reckoning", converted.poses_by_dead_reckoning)
      .add("records_skipped", "records skipped", log->records_skipped());
  auto notes = nlohmann::ordered_json::array();
  for (const std::string& note : writer->notes()) notes.push_back(note);
  result.add_json("notes", notes);
  result.print(context);
  return kExitDone;
}

}  // namespace

void add_convert_command(CLI::App& app, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("convert", "Write a log in another format");
  command->add_option("IN", arguments->input, "a log file or folder")->required();
  command->add_option("OUT", arguments->output, "the log to write")->required();
  command->add_option("--format", arguments->format, "of OUT (default: by its name)")
      ->type_name("carmen|ucsd")
      ->check(CLI::IsMember({"carmen", "ucsd"}));
  command->add_flag("--force", arguments->force, "overwrite OUT");
  command->add_flag("--strict", arguments->strict, "damage in the log is an error");
  context.add_robot_flag(*command);
  context.add_common_flags(*command);
  command->footer(kFooter);
  context.on_run(*command, [arguments, &context] { return run(*arguments, context); });
}

}  // namespace loopstone::app
