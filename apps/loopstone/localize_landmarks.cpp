#include "localize_landmarks.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <utility>

#include "interrupt.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/landmark_file.hpp"
#include "loopstone/pipeline/log_landmarks.hpp"
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

/// Of MRCLAM's sightings.
LocalizationResult follow_mrclam(LandmarkRun& run, const LandmarkMap& map,
                                 const LandmarkArguments& arguments, const std::string& path,
                                 const LogFlags& reading, const LogCut& cut,
                                 const LandmarkTrackingOptions& options,
                                 const std::optional<InitialPose>& initial,
                                 const AppContext& context) {
  const MrclamLog log = read_mrclam_run(path, reading, options.sightings, context);
  run.left_out = left_out_of(log);
  return localize_mrclam(log, readings_within(log, cut, arguments.nameless), context.robot(), map,
                         options, initial, interrupted);
}

/// Of reflectors in scans.
LocalizationResult follow_scans(LandmarkRun& run, const LandmarkMap& map, const std::string& path,
                                const LogFlags& reading, const LogCut& cut,
                                const LandmarkTrackingOptions& options,
                                const std::optional<InitialPose>& initial,
                                const AppContext& context) {
  ProblemPrinter print_problem(context);
  LogOptions how = log_options(reading, context, &print_problem);
  how.intensities = true;
  const LogSource source = source_of(path, std::move(how), context);
  const auto reader = source.open();
  tell_choices(*reader, context);
  ProgressDisplay display(context);
  LogLocalization done =
      localize_by_reflectors(source, *reader, map, options, initial, cut, watch_by(display));
  ProgressDisplay::clear_line();
  run.left_out = done.log.left_out;
  return std::move(done.result);
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
  run.result =
      is_mrclam_log(log)
          ? follow_mrclam(run, map, arguments, log, reading, cut, options, initial, context)
          : follow_scans(run, map, log, reading, cut, options, initial, context);
  run.result.complete = run.result.complete && !interrupted();
  return run;
}

}  // namespace loopstone::app
