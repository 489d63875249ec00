#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bounds.hpp"
#include "commands.hpp"
#include "initial_pose.hpp"
#include "interrupt.hpp"
#include "known_map.hpp"
#include "localize_landmarks.hpp"
#include "log_run.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/localization/localizer.hpp"
#include "loopstone/pipeline/log_localization.hpp"
#include "loopstone/report/localization_figures.hpp"
#include "loopstone/report/localization_outputs.hpp"
#include "loopstone/report/peak_memory.hpp"
#include "output_path.hpp"
#include "result.hpp"

namespace loopstone::app {

namespace {

using Clock = std::chrono::steady_clock;

struct Arguments {
  std::string log;
  std::string map;
  LandmarkArguments landmarks;
  std::string output;
  std::string initial;
  std::string initial_sigma;
  bool global = false;
  std::optional<std::int64_t> particles;
  std::uint64_t seed = 1;
  LogCut cut;
  bool no_calibration = false;
  std::string report;
  std::string animation;
  std::vector<std::string> require;
  bool force = false;
  LogFlags reading;
};

/// Snapshots for an animation, unless the user wants others.
constexpr double kAnimationStepM = 0.5;

constexpr const char* kFooter = R"(
MAP is a map.yaml with its picture, as ROS map_server reads it (any mode), or a folder that `loopstone map` left.
FILE.tum holds map_T_robot at every scan (t x y z qx qy qz qw); FILE.csv, beside it, the same with covariance, state,
probability and what that stands on. The same seed gives the same files, with any number of threads.

Without a map of cells, among reflectors or beacons of known places (docs/localization.md): --landmarks FILE with a line
of id,x_m,y_m and optionally sigma_m,radius_m, then a line for each; or UTIAS MRCLAM's Landmark_Groundtruth.dat. Reflectors
are found in scans with intensities; an MRCLAM folder is a LOG of its own, DIR#2 its robot 2.

State: TRACKING  the pose is right, by all that can be told
       DOUBTFUL  it may be right, or another place looks the same: wait, or drive on
       LOST      it is wrong, or there is none yet; the map is searched until there is
The probability is that of the pose being within 0.2 m and 5 deg of the truth.

Examples:
  loopstone localize sim --map sim/map.yaml -o where.tum --global                    from anywhere on the map
  loopstone localize sim --map out -o where.tum --initial 4,3,0.5 --report where     from a guess; open where/report.html
  loopstone localize sim --map out -o where.tum --global --animation film --set snapshot_distance_m=0.2
  loopstone localize sim --map out -o where.tum --global --require 'tracking_share>=0.9'    exits with 3 if it is less
  loopstone localize sim/log.mcap --landmarks sim/landmarks.csv -o where.tum --global          by reflectors alone
  loopstone evaluate --estimate where.tum --reference sim/truth.tum --align none     how far off it was)";

/// One kind of map, and nothing said that the other one needs.
void check_map_of(const Arguments& arguments) {
  const LandmarkArguments& landmarks = arguments.landmarks;
  if (arguments.map.empty() == landmarks.file.empty()) {
    throw UsageError(
        "on which map? --map MAP for one of cells, or --landmarks FILE for places of "
        "reflectors or beacons");
  }
  if (landmarks.file.empty() && (landmarks.nameless || landmarks.brightness)) {
    throw UsageError("--nameless and --reflector-threshold need --landmarks");
  }
  if (!landmarks.file.empty() && arguments.particles) {
    throw UsageError("--particles: among landmarks there are none; leave it out");
  }
}

std::optional<InitialPose> initial_of(const Arguments& arguments) {
  if (arguments.global && !arguments.initial.empty()) {
    throw UsageError("--initial and --global exclude each other: a guess, or anywhere on the map");
  }
  if (!arguments.global && arguments.initial.empty()) {
    throw UsageError(
        "where does the robot start? --initial X,Y,YAW if that is about known, else --global");
  }
  if (arguments.global && !arguments.initial_sigma.empty()) {
    throw UsageError("--initial-sigma says how good --initial is; --global has none");
  }
  return initial_pose(arguments.initial, arguments.initial_sigma);
}

LocalizationOptions options_of(const Arguments& arguments, const AppContext& context) {
  auto options = context.load_options<LocalizationOptions>();
  std::vector<OptionProblem> problems;
  if (arguments.particles) {
    override_option(list_options(options), "--particles",
                    fmt::format("particles_max={}", *arguments.particles), problems);
    options.particles_min = std::min(options.particles_min, options.particles_max);
  }
  if (!problems.empty()) throw OptionsError(problems);
  if (!arguments.animation.empty() && options.snapshot_distance_m == 0.0)
    options.snapshot_distance_m = kAnimationStepM;
  return options;
}

/// What is read and written, held against each other before the work.
Outputs outputs_of(const Arguments& arguments, const AppContext& context) {
  Outputs outputs(context, arguments.force);
  if (arguments.landmarks.file.empty()) {
    outputs.reads_log(arguments.log);
    outputs.reads(arguments.map);
    outputs.reads(map_yaml_of(arguments.map));
  } else {
    for (const std::string& path : landmark_log_files(arguments.log)) outputs.reads(path);
    outputs.reads(arguments.landmarks.file);
  }
  add_trajectory_output(arguments.output, outputs);
  if (!arguments.report.empty()) outputs.add_folder("--report", arguments.report);
  if (!arguments.animation.empty()) outputs.add_folder("--animation", arguments.animation);
  return outputs;
}

/// Says what is odd about the place; it may still be right by its spread.
void warn_of_initial_pose(const InitialPose& initial, const Grid<std::int8_t>& map,
                          const AppContext& context) {
  const GridFrame& frame = map.frame();
  const Pose2& pose = initial.map_T_robot;
  const Cell cell = frame.cell_of(pose.translation());
  const std::string place = fmt::format("--initial {:g},{:g}", pose.x, pose.y);
  if (!frame.contains(cell)) {
    context.warn(fmt::format(
        "{} lies outside the map, which goes from ({:.1f}, {:.1f}) to ({:.1f}, {:.1f}) m", place,
        frame.origin.x(), frame.origin.y(), frame.origin.x() + frame.columns * frame.resolution,
        frame.origin.y() + frame.rows * frame.resolution));
    return;
  }
  constexpr int kWallPercent = 65;  // map_server's own threshold
  if (map[cell] >= kWallPercent) {
    context.warn(place + " lies in a wall of the map");
  } else if (map[cell] == kUnknownCell) {
    context.warn(place + " lies where the map knows nothing");
  }
}

LocalizationRunInfo info_of(const Arguments& arguments, const LeftOut& left_out,
                            LocalizationOptions& options, const LocalizationMap& map,
                            const std::optional<InitialPose>& initial, const AppContext& context) {
  LocalizationRunInfo info;
  info.run = run_info(arguments.log, left_out, arguments.force, context);
  info.run.options_toml = options_to_toml(list_options(options));
  info.map_path = arguments.map;
  info.initial = initial;
  info.seed = arguments.seed;
  info.map_free_area_m2 = map.free_area_m2();
  info.map_memory_bytes = static_cast<std::int64_t>(map.memory_bytes());
  return info;
}

/// What was written, for the table.
struct Written {
  std::string csv;
  std::int64_t pictures = 0;
};

Written write_results(const LocalizationResult& result, const Grid<std::int8_t>& occupancy,
                      const LocalizationRunInfo& info, const Arguments& arguments) {
  Written written;
  written.csv = write_localization_trajectory(result, arguments.output);
  if (!arguments.report.empty())
    write_localization_outputs(result, occupancy, info, arguments.report);
  if (!arguments.animation.empty()) {
    written.pictures =
        write_localization_animation(result, occupancy, arguments.animation, arguments.force);
  }
  return written;
}

void print_table(const LocalizationResult& result, const RunInfo& run, const Arguments& arguments,
                 const Written& written, const AppContext& context) {
  const LocalizationFigures figures = figures_of(result);
  Result table;
  table.add_row("scans", fmt::format("{}", result.scans));
  if (const auto skipped = run.left_out.skipped.records; skipped > 0)
    table.add_row("records skipped", fmt::format("{}", skipped));
  table.add_row("recording", fmt::format("{:.1f}", result.duration_s), "s");
  table.add_row("path", fmt::format("{:.1f}", result.path_length_m), "m");
  for (const auto& [label, share] : {std::pair{"TRACKING", figures.tracking_share},
                                     {"DOUBTFUL", figures.doubtful_share},
                                     {"LOST", figures.lost_share}}) {
    table.add_row(label, fmt::format("{:5.1f} % of the time", 100.0 * share));
  }
  table.add_row("first TRACKING",
                figures.first_tracking_s
                    ? fmt::format("after {:.1f} s, {:.1f} m", *figures.first_tracking_s,
                                  figures.first_tracking_m.value_or(0.0))
                    : std::string("never"));
  table.add_row("searches", fmt::format("{}", result.searches.size()));
  table.add_row("mean probability", fmt::format("{:.3f}", figures.probability_mean));
  table.add_row("time", fmt::format("{:.2f} s, {:.0f} x real time", run.wall_time_s,
                                    result.duration_s / std::max(run.wall_time_s, 1e-9)));
  table.add_row("trajectory",
                arguments.output + (written.csv.empty() ? "" : ", with all else " + written.csv));
  if (!arguments.report.empty()) table.add_row("report", arguments.report + "/report.html");
  if (!arguments.animation.empty()) {
    table.add_row("animation", fmt::format("{}, {} picture{}", arguments.animation,
                                           written.pictures, written.pictures == 1 ? "" : "s"));
  }
  table.print(context);
}

/// Prints warnings and figures; the exit code says how the run ended.
ExitCode tell(const LocalizationResult& result, const Grid<std::int8_t>& occupancy,
              const LocalizationRunInfo& info, const Written& written,
              const std::vector<Bound>& bounds, const Arguments& arguments,
              const AppContext& context) {
  for (const std::string& warning : result.warnings) context.warn(warning);
  const auto missed = missed_bounds(bounds, summary_figures(result, occupancy, info));
  if (context.json()) {
    print_to_stdout(format_summary(result, occupancy, info));
  } else {
    print_table(result, info.run, arguments, written, context);
  }
  const ExitCode code = report_missed(missed, context);
  if (result.complete) return code;
  context.warn("interrupted: the poses are those until then");
  return kExitInterrupted;
}

/// As it is given, or else as its driving tells it.
DrivenRobot robot_for(const Arguments& arguments, const LogSource& source, const RobotModel& told,
                      const ReadingWatch& watch, const AppContext& context) {
  if (arguments.no_calibration) return {.model = told, .mounts_from_log = source.mounts_from_log()};
  return robot_as_driven(source, told, arguments.cut, context.threads(), watch);
}

/// Among landmarks, which need neither a map of cells nor particles.
ExitCode run_by_landmarks(const Arguments& arguments, const std::optional<InitialPose>& initial,
                          const std::vector<Bound>& bounds, const AppContext& context) {
  const auto start = Clock::now();
  const Outputs outputs = outputs_of(arguments, context);
  outputs.check();
  const HeldInterrupt held;
  outputs.prepare();
  const LandmarkRun run =
      localize_by_landmarks(arguments.landmarks, arguments.log, arguments.reading, arguments.cut,
                            initial, arguments.animation.empty() ? 0.0 : kAnimationStepM, context);
  LocalizationRunInfo info;
  info.run = run_info(arguments.log, run.left_out, arguments.force, context);
  info.run.options_toml = run.options_toml;
  info.map_path = arguments.landmarks.file;
  info.initial = initial;
  info.seed = arguments.seed;
  info.run.wall_time_s = std::chrono::duration<double>(Clock::now() - start).count();
  const Written written = write_results(run.result, run.drawing, info, arguments);
  info.run.peak_memory_bytes = peak_memory_bytes();
  return tell(run.result, run.drawing, info, written, bounds, arguments, context);
}

ExitCode run(const Arguments& arguments, const AppContext& context) {
  const auto start = Clock::now();
  const std::vector<Bound> bounds = parse_bounds(arguments.require);
  check_map_of(arguments);
  const std::optional<InitialPose> initial = initial_of(arguments);
  if (!arguments.landmarks.file.empty())
    return run_by_landmarks(arguments, initial, bounds, context);
  LocalizationOptions options = options_of(arguments, context);

  const LogFiles log_files(arguments.log);
  const Outputs outputs = outputs_of(arguments, context);
  outputs.check(least_bytes_of_results(log_files.bytes()));
  const LocalizationMap map = read_known_map(arguments.map, context.memory(), context.threads());
  if (initial) warn_of_initial_pose(*initial, map.occupancy(), context);
  ProblemPrinter print_problem(context);
  const LogSource source =
      source_of(arguments.log, log_options(arguments.reading, context, &print_problem), context);
  const auto reader = source.open();
  tell_choices(*reader, context);
  ProgressDisplay display(context);
  const ReadingWatch watch = watch_by(display);
  const DrivenRobot robot = robot_for(arguments, source, source.robot_of(*reader), watch, context);
  const HeldInterrupt held;
  outputs.prepare();
  const LogLocalization done =
      localize_log(source, *reader, robot, map, options, initial, arguments.seed, arguments.cut,
                   context.threads(), watch);
  const LocalizationResult& result = done.result;
  ProgressDisplay::clear_line();

  LocalizationRunInfo info = info_of(arguments, done.log.left_out, options, map, initial, context);
  info.run.wall_time_s = std::chrono::duration<double>(Clock::now() - start).count();
  const Written written = write_results(result, map.occupancy(), info, arguments);
  info.run.peak_memory_bytes = peak_memory_bytes();
  return tell(result, map.occupancy(), info, written, bounds, arguments, context);
}

}  // namespace

void add_localize_command(CLI::App& app, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("localize", "Where the robot was on a known map, and how sure that is");
  command
      ->add_option("LOG", arguments->log,
                   "a log file, or a folder (DIR#20 names set 20 of a UCSD folder)")
      ->required();
  command->add_option("--map", arguments->map, "a map.yaml, a folder that holds one, or a site")
      ->type_name("MAP");
  add_landmark_flags(*command, arguments->landmarks);
  command
      ->add_option("-o,--output", arguments->output,
                   "the trajectory to write; FILE.csv beside it holds all else")
      ->type_name("FILE.tum")
      ->required();
  command
      ->add_option("--initial", arguments->initial,
                   "about where the robot is at the first scan [m, m, rad]")
      ->type_name("X,Y,YAW");
  command
      ->add_option("--initial-sigma", arguments->initial_sigma,
                   "standard deviations of that (default: 0.5,0.26)")
      ->type_name("M,RAD");
  command->add_flag("--global", arguments->global, "it may be anywhere on the map");
  command
      ->add_option("--particles", arguments->particles,
                   "at most so many (default: option particles_max)")
      ->type_name("N");
  command->add_option("--seed", arguments->seed, "of the particles")
      ->type_name("N")
      ->capture_default_str();
  add_cut_flags(*command, arguments->cut);
  command
      ->add_option("--report", arguments->report,
                   "folder for a page with pictures and plots; made, or empty unless --force")
      ->type_name("DIR");
  command
      ->add_option("--animation", arguments->animation,
                   "folder for a numbered series of pictures, one every half metre of the path")
      ->type_name("DIR");
  command->add_flag("--no-calibration", arguments->no_calibration,
                    "take laser and odometry as they are given; --robot does so, too");
  add_require_flag(*command, arguments->require);
  add_log_flags(*command, arguments->reading);
  command->add_flag("--force", arguments->force,
                    "replace files, and write into folders that are not empty");
  context.add_common_flags(*command);
  context.add_threads_flag(*command);
  context.add_option_flags(*command);
  context.add_robot_flag(*command);
  command->footer(kFooter);
  context.on_run(*command, [arguments, &context] { return run(*arguments, context); });
}

}  // namespace loopstone::app
