#include "localize_landmarks.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <utility>

#include "interrupt.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/landmark_file.hpp"
#include "loopstone/formats/mrclam.hpp"
#include "loopstone/localization/landmark_tracker.hpp"
#include "loopstone/report/landmark_drawing.hpp"
#include "mrclam_run.hpp"

namespace loopstone::app {
namespace {

/// What the landmark's file makes of the map; its own errors name the file.
LandmarkMap read_map(const std::string& path, const MemoryBudget& budget) {
  try {
    return LandmarkMap(read_landmarks(path, budget));
  } catch (const UsageError& error) {
    throw DataError({path}, error.what());
  }
}

LandmarkTrackingOptions options_of(const LandmarkArguments& arguments, double snapshot_distance_m,
                                   const AppContext& context) {
  auto options = context.load_options<LandmarkTrackingOptions>();
  std::vector<OptionProblem> problems;
  if (arguments.brightness) {
    override_option(list_options(options), "--reflector-threshold",
                    fmt::format("reflectors.brightness={}", *arguments.brightness), problems);
  }
  if (!problems.empty()) throw OptionsError(problems);
  if (options.snapshot_distance_m == 0.0) options.snapshot_distance_m = snapshot_distance_m;
  return options;
}

/// Readings wait in the tracker for odometry of their time.
void follow_mrclam(LandmarkRun& run, LandmarkTracker& tracker, const LandmarkArguments& arguments,
                   const std::string& path, const LogFlags& reading, const LogCut& cut,
                   const SightingNoise& noise, const AppContext& context) {
  const MrclamLog log = read_mrclam_run(path, reading, noise, context);
  for (const LandmarkReading& seen : readings_within(log, cut, arguments.nameless))
    tracker.add(seen);
  for (const OdometryPose& pose : log.odometry) {
    if (interrupted()) break;
    tracker.add(pose);
  }
  run.result = tracker.finish();
  run.left_out = left_out_of(log);
}

/// Reflectors need intensities, and enough of them.
void require_reflectors(const LandmarkTracker& tracker, const std::string& path) {
  if (tracker.scans_with_intensities() == 0) {
    throw DataError({path},
                    "its scans have no intensities, by which reflectors are told; MCAP, ROS 1 bags "
                    "and rosbag2 hold them where the driver tells them");
  }
  if (tracker.observations() == 0) {
    throw DataError({path},
                    "no beam is bright enough to be one on a reflector; a lower "
                    "--reflector-threshold takes fainter ones");
  }
}

void follow_scans(LandmarkRun& run, LandmarkTracker& tracker, LogReader& reader,
                  const std::string& path, const LogCut& cut, const AppContext& context) {
  ProgressDisplay display(context);
  CutLog log(reader, cut, !context.robot_given(), "localising", watch_by(display));
  while (const auto message = log.next()) tracker.add(*message);
  run.result = tracker.finish();
  ProgressDisplay::clear_line();
  const LogSummary judged = log.judge(path);
  if (!log.interrupted()) require_reflectors(tracker, path);
  run.result.warnings = warnings_of(judged);
  run.left_out = judged.left_out;
}

}  // namespace

void add_landmark_flags(CLI::App& command, LandmarkArguments& arguments) {
  command
      .add_option("--landmarks", arguments.file,
                  "instead of --map: places of reflectors or beacons (id,x_m,y_m as CSV), or "
                  "MRCLAM's folder")
      ->type_name("FILE");
  command.add_flag("--nameless", arguments.nameless,
                   "of --landmarks: do not use which landmark was seen");
  command
      .add_option("--reflector-threshold", arguments.brightness,
                  "of --landmarks: so many times brighter than usual at its range a beam on a "
                  "reflector is (default: option reflectors.brightness)")
      ->type_name("N");
}

std::vector<std::string> landmark_log_files(const std::string& log) {
  return is_mrclam_log(log) ? mrclam_log_files(log) : LogFiles(log).paths();
}

LandmarkRun localize_by_landmarks(const LandmarkArguments& arguments, const std::string& log,
                                  const LogFlags& reading, const LogCut& cut,
                                  const std::optional<InitialPose>& initial,
                                  double snapshot_distance_m, const AppContext& context) {
  LandmarkTrackingOptions options = options_of(arguments, snapshot_distance_m, context);
  const LandmarkMap map = read_map(arguments.file, context.memory());
  LandmarkRun run;
  run.drawing = drawn_landmarks(map.landmarks());
  run.options_toml = options_to_toml(list_options(options));
  if (is_mrclam_log(log)) {
    LandmarkTracker tracker(map, context.robot(), options, initial);
    follow_mrclam(run, tracker, arguments, log, reading, cut, options.sightings, context);
  } else {
    ProblemPrinter print_problem(context);
    LogOptions how = log_options(reading, context, &print_problem);
    how.intensities = true;
    const auto reader = open_log(log, how);
    tell_choices(*reader, context);
    LandmarkTracker tracker(map, robot_of(*reader, context), options, initial);
    follow_scans(run, tracker, *reader, log, cut, context);
  }
  run.result.complete = run.result.complete && !interrupted();
  return run;
}

}  // namespace loopstone::app
