#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "app.hpp"
#include "commands.hpp"
#include "floor_run.hpp"
#include "interrupt.hpp"
#include "log_run.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/release_memory.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/mrclam.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "loopstone/formats/session_file.hpp"
#include "loopstone/report/map_figures.hpp"
#include "loopstone/report/map_outputs.hpp"
#include "loopstone/report/peak_memory.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/version.hpp"
#include "map_landmarks.hpp"
#include "map_pipeline.hpp"
#include "map_text.hpp"
#include "output_path.hpp"
#include "pace.hpp"
#include "session_folder.hpp"
#include "word_flag.hpp"

namespace loopstone::app {

namespace {

constexpr const char* kFooter = R"(
OUT then holds report.html (all of it on one page), map.pgm with map.yaml (as ROS map_server reads it) and map.png, trajectory.tum
(map_T_robot at every scan: t x y z qx qy qz qw) and trajectory.csv (the same with covariances), graph.g2o, loop_closures.csv,
quality.png (where visits disagree), summary.json and options.toml; docs/formats.md has them all. The verdict is good, doubtful or
bad, with what it stands on and where: a map that may be wrong is not called good.

Examples:
  loopstone map run.mcap -o out                         a ROS 2 recording as it is; open out/report.html
  loopstone map run.bag -o out --view                   and watch it in the browser while it is made
  loopstone map ucsd#20 -o out --robot robot.toml       a folder of the UCSD layout, wheels and mounts from a file
  loopstone map monday.mcap -o monday --keep-state && \
  loopstone map tuesday.mcap -o both --continue monday  another drive in the same building, from anywhere in it
  loopstone map long.mcap -o out --checkpoint 30        survives a power cut: the same again with --resume goes on
  loopstone map run.mcap -o out --set map.resolution_m=0.02 --json | jq .quality.verdict)";

/// What the camera has to do with the files.
std::string colour_of(const MapArguments& arguments) {
  if (arguments.no_texture) return "none";
  return arguments.cloud ? "floor, cloud" : "floor";
}

/// Whether the folder holds the results of this very run: it may have been killed when nothing was
/// left to do but to say so, and who starts it again must not fail for it. Throws UsageError when
/// they are of another one.
ExitCode show_results(CutLog& log, const MapArguments& arguments, const SessionTerms& terms,
                      const AppContext& context) {
  LogDigest digest;
  while (const auto message = log.next()) digest.add(*message);
  const auto summary =
      find_results(arguments.out, terms, result_terms(terms, colour_of(arguments), digest));
  if (!summary) {
    throw UsageError(arguments.out +
                     ": is not empty, it holds the results of another run; choose another folder "
                     "or add --force to overwrite");
  }
  context.note(arguments.out + ": holds the results of this run already; --force makes them anew");
  if (context.json()) print_to_stdout(*summary);
  return kExitDone;
}

/// What the log gives reason to say of the map, which is then known to who looks on.
void add_judgement(const LogSummary& judged, const std::vector<std::string>& changes,
                   bool interrupted_log, MapResult& result, MapFeed* feed) {
  judge_by_log(judged, changes, result);
  result.complete = result.complete && !interrupted_log;
  if (feed != nullptr) feed->finish(result);
}

/// The floor in colour, if the log has pictures. A failure leaves all else and is told in `info`.
std::optional<FloorTexture> colour(CameraFrames& camera, const MapArguments& arguments,
                                   TextureOptions options, const RobotModel& robot,
                                   const AppContext& context, ProgressDisplay& display,
                                   MapResult& result, RunInfo& info) {
  // Its pictures have the clock of the newest drive, the trajectory the map's.
  const bool has_drives = !result.drives.empty();
  if (arguments.no_texture || has_drives || camera.complete() == 0 || !result.complete) return {};
  if (!context.robot_given() && !camera.fault().empty()) {
    result.warnings.push_back("the floor is not coloured: " + camera.fault() +
                              "; --robot FILE can tell it");
    return {};
  }
  if (arguments.cloud) gather_cloud(options);
  try {
    auto texture = colour_floor(camera, result.trajectory, robot, options, context, display);
    result.complete = texture.complete;
    return texture;
  } catch (const std::exception& error) {
    info.failure = std::string("the floor could not be coloured: ") + error.what();
    return {};
  }
}

/// A failure leaves all else and is told in `info`.
void finish(RunRecording& recording, const MapResult& result, RunInfo& info) {
  recording.finish(result);
  if (recording.failure().empty()) return;
  if (!info.failure.empty()) info.failure += "; ";
  info.failure += recording.failure();
}

/// What this run took, and those before it that led to the same result.
void note_cost(std::chrono::steady_clock::time_point start, const Checkpoint& checkpoint,
               const std::optional<Pace>& pace, RunInfo& info) {
  if (pace) info.pace = pace->figures();
  info.cpu_time_s = cpu_seconds() + checkpoint.earlier_cpu_s();
  info.peak_memory_bytes = peak_memory_bytes();
  info.wall_time_s =
      checkpoint.earlier_wall_s() +
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

SessionTerms terms_of(const MapArguments& arguments, MapPipeline& pipeline, const RobotModel& robot,
                      const AppContext& context) {
  return {.version = std::string(kVersion),
          .options_toml = pipeline.options_toml() + log_flags_comment(arguments.reading),
          .robot_toml = robot_to_toml(robot),
          .mounts_from_log = !context.robot_given(),
          .start_s = arguments.cut.start_s,
          .duration_s = arguments.cut.duration_s,
          .max_scans = arguments.cut.max_scans};
}

Outputs outputs_of(const MapArguments& arguments, RunStart begin, const AppContext& context) {
  Outputs outputs(context, arguments.force);
  outputs.reads_log(arguments.log);
  if (!arguments.drives.from.empty()) outputs.reads(kept_state_path(arguments.drives.from));
  outputs.add_folder("-o", arguments.out, begin != RunStart::kLog);
  if (!arguments.mcap.empty()) outputs.add_file("--mcap", arguments.mcap);
  return outputs;
}

LogSource source_for(const MapArguments& arguments, const AppContext& context,
                     ProblemPrinter& print_problem) {
  LogFlags flags = arguments.reading;
  flags.pictures = !arguments.no_texture;
  LogOptions how = log_options(flags, context, &print_problem);
  how.intensities = arguments.landmarks.on;
  return source_of(arguments.log, std::move(how), context);
}

/// A map whose beams are bent or mirrored is made anew from the beginning of the log.
void correct_beams(const MapArguments& arguments, const LogSource& source, MapPipeline& pipeline,
                   ProgressDisplay& display, MapResult& result) {
  while (pipeline.is_bent()) {
    result = {};  // its memory is needed
    const auto reader = source.open_again();
    CutLog log(*reader, arguments.cut, source.mounts_from_log(), "mapping anew", watch_by(display));
    result = pipeline.map_anew(log);
    ProgressDisplay::clear_line();
  }
}

std::optional<Pace> pace_of(const MapArguments& arguments) {
  if (!(arguments.realtime > 0.0)) return {};
  return std::optional<Pace>(std::in_place, arguments.realtime);
}

RunInfo info_of(const LogSummary& judged, const MapArguments& arguments,
                const MapPipeline& pipeline, const AppContext& context) {
  const bool may_overwrite = arguments.force || arguments.checkpoint.any();
  RunInfo info = run_info(arguments.log, judged.left_out, may_overwrite, context);
  info.log_warnings = warnings_of(judged);
  const std::vector<std::string> corrections = pipeline.corrections();
  info.log_warnings.insert(info.log_warnings.end(), corrections.begin(), corrections.end());
  return info;
}

/// By what the results are known again; those that go on with others are of more than one log.
void note_terms(const Checkpoint& checkpoint, const MapArguments& arguments,
                const MapPipeline& pipeline, RunInfo& info) {
  info.options_toml = checkpoint.terms().options_toml;
  if (pipeline.has_sessions() && arguments.drives.from.empty())
    info.terms = result_terms(checkpoint.terms(), colour_of(arguments), checkpoint.log());
}

/// What the states have in common that --continue goes on from.
SessionTerms state_terms(MapPipeline& pipeline) {
  return {.version = std::string(kVersion), .options_toml = pipeline.options_toml()};
}

std::optional<MapperState> state_before(const MapArguments& arguments, MapPipeline& pipeline,
                                        const AppContext& context) {
  if (arguments.drives.from.empty()) return {};
  return read_state(arguments.drives.from, state_terms(pipeline), context);
}

void prepare(const Outputs& outputs, RunStart begin, const MapArguments& arguments,
             const AppContext& context) {
  if (begin == RunStart::kLog && arguments.checkpoint.resume)
    context.note(arguments.out + ": holds no session yet; from the beginning");
  outputs.prepare();
  if (begin == RunStart::kLog) remove_session(arguments.out);
}

/// A state beside the results is theirs: one of an older map goes.
void leave_state(std::optional<MapperState> kept, const MapResult& result, const RobotModel& robot,
                 const MapArguments& arguments, MapPipeline& pipeline) {
  if (kept && result.complete) {
    SessionTerms terms = state_terms(pipeline);
    terms.robot_toml = robot_to_toml(robot);
    write_session(kept_state_path(arguments.out),
                  {.terms = std::move(terms), .mapper = std::move(*kept)});
  } else {
    remove_kept_state(arguments.out);
  }
}

/// The results, and what they were made of where it is to be kept.
void write_all(const MapResult& result, const MapExtras& extras, std::optional<MapperState> kept,
               const RobotModel& robot, const MapArguments& arguments, MapPipeline& pipeline,
               const Checkpoint& checkpoint, RunInfo& info, const AppContext& context) {
  release_unused_memory();
  write_map_outputs(result, info, arguments.out, extras);
  leave_state(std::move(kept), result, pipeline.made_by(robot), arguments, pipeline);
  info.peak_memory_bytes = peak_memory_bytes();
  end_session(arguments.out, arguments.checkpoint, checkpoint,
              result.complete && info.failure.empty(), context);
}

/// All is written: Ctrl-C ends the view, and nothing else.
void stay_open(LiveView& view, std::optional<HeldInterrupt>& held, const AppContext& context) {
  held.reset();
  view.stay_open(context);
}

/// Who looks on while a map is made.
struct MapWatch {
  LiveView view;
  MapFeed feed;
  MapWatch(const MapArguments& arguments, const MapPipeline& pipeline, const RobotModel& robot,
           const AppContext& context)
      : view(arguments.view_flags,
             {.name = std::filesystem::path(arguments.log).filename().string(), .mode = "mapping"}),
        feed(view.board(), robot, pipeline.map_options()) {
    view.open(context);
  }
  ~MapWatch() { view.close(); }
  MapWatch(const MapWatch&) = delete;
  MapWatch& operator=(const MapWatch&) = delete;
};

std::unique_ptr<MapWatch> watch_of(const MapArguments& arguments, const MapPipeline& pipeline,
                                   const RobotModel& robot, const AppContext& context) {
  if (!arguments.view) return nullptr;
  return std::make_unique<MapWatch>(arguments, pipeline, robot, context);
}

MapPlaces places_of(const MapArguments& arguments) {
  return {.out = arguments.out,
          .mcap = arguments.mcap,
          .goes_on = arguments.checkpoint.any() ? "; --resume goes on from there" : ""};
}

ExitCode run_map(const MapArguments& arguments, const AppContext& context) {
  const auto start = std::chrono::steady_clock::now();
  MapPipeline pipeline(arguments, context);

  const RunStart begin = find_start(arguments.out, arguments.checkpoint, arguments.force);
  const LogFiles log_files(arguments.log);
  const Outputs outputs = outputs_of(arguments, begin, context);
  outputs.check(least_bytes_of_results(log_files.bytes()));

  ProblemPrinter print_problem(context);
  const LogSource source = source_for(arguments, context, print_problem);
  const auto reader = source.open_ahead(context.threads());
  tell_choices(*reader, context);
  const RobotModel robot = source.robot_of(*reader);

  ProgressDisplay display(context);
  CutLog log(*reader, arguments.cut, source.mounts_from_log(), "mapping", watch_by(display));
  Checkpoint checkpoint(session_in(arguments.out, arguments.checkpoint, context),
                        terms_of(arguments, pipeline, robot, context));
  if (begin == RunStart::kResults) return show_results(log, arguments, checkpoint.terms(), context);
  std::optional<MapperState> before = state_before(arguments, pipeline, context);
  const auto watch = watch_of(arguments, pipeline, robot, context);
  MapFeed* const feed = watch ? &watch->feed : nullptr;
  prepare(outputs, begin, arguments, context);
  CameraFrames camera;
  std::optional<Pace> pace = pace_of(arguments);
  RunRecording recording(arguments.mcap, robot, pipeline.map_options());
  std::optional<HeldInterrupt> held;
  std::optional<MapperState> kept;
  MapResult result = pipeline.map({.log = log,
                                   .camera = camera,
                                   .checkpoint = checkpoint,
                                   .pace = pace,
                                   .display = display,
                                   .recording = recording,
                                   .feed = feed,
                                   .out = arguments.out,
                                   .resumes = begin == RunStart::kSession,
                                   .continues = arguments.drives.from,
                                   .begins_with = std::move(before),
                                   .keeps_state = arguments.drives.keep_state},
                                  robot, context.threads(), held, kept);
  ProgressDisplay::clear_line();
  const LogSummary judged = log.judge(arguments.log);
  correct_beams(arguments, source, pipeline, display, result);
  camera.take_pictures(*reader);
  add_judgement(judged, log_files.changes(), log.interrupted(), result, feed);

  RunInfo info = info_of(judged, arguments, pipeline, context);
  const auto texture =
      colour(camera, arguments, pipeline.texture(), robot, context, display, result, info);
  const auto landmarks = pipeline.landmarks_of(result, info.failure);
  const MapExtras extras{texture ? &*texture : nullptr, landmarks ? &*landmarks : nullptr};
  finish(recording, result, info);

  note_terms(checkpoint, arguments, pipeline, info);
  note_cost(start, checkpoint, pace, info);
  write_all(result, extras, std::move(kept), robot, arguments, pipeline, checkpoint, info, context);
  const ExitCode code = tell_map(result, extras, info, places_of(arguments), context);
  if (watch) stay_open(watch->view, held, context);
  return code;
}

}  // namespace

void add_map_command(CLI::App& app, AppContext& context) {
  auto arguments = std::make_shared<MapArguments>();
  CLI::App* command = app.add_subcommand("map", "Turn a log into a trajectory, a map and a report");
  command
      ->add_option("LOG", arguments->log,
                   "a log file, or a folder (DIR#20 names set 20 of a UCSD folder)")
      ->required();
  command
      ->add_option("-o,--out", arguments->out,
                   "folder for the results; made, or empty unless --force")
      ->required();
  add_word_flag(*command, "--pipeline", arguments->pipeline,
                "submaps, or the textbook's scan_to_scan to compare with");
  add_cut_flags(*command, arguments->cut);
  add_word_flag(*command, "--odometry", arguments->odometry,
                "used while it agrees with the laser, always, or not at all (default: check)");
  command->add_flag("--no-loop-closure", arguments->no_loop_closure,
                    "do not correct the map where places are seen again");
  command->add_flag("--no-calibration", arguments->no_calibration,
                    "take the laser's mount as it is told, whatever the drive tells of it");
  command->add_flag("--no-texture", arguments->no_texture,
                    "leave out the colour of the floor, though the log has RGB-D");
  command->add_flag("--cloud", arguments->cloud,
                    "also cloud.ply: everything the RGB-D camera saw, in colour");
  command
      ->add_option(
          "--realtime", arguments->realtime,
          "replay at SPEED times the log's own pace, 1 as recorded, and tell how long poses "
          "were waited for")
      ->type_name("SPEED")
      ->check(CLI::Range(0.001, 1e6));
  command
      ->add_option("--mcap", arguments->mcap,
                   "also the run as a recording to watch in Foxglove, Lichtblick or RViz: scans, "
                   "transforms, the map as it grows, path, closures, faults")
      ->type_name("FILE");
  command->add_flag("--view", arguments->view,
                    "show the map in the browser while it is made, until Ctrl-C afterwards");
  add_view_flags(*command, arguments->view_flags);
  add_landmark_map_flags(*command, arguments->landmarks);
  add_checkpoint_flags(*command, arguments->checkpoint);
  add_continue_flags(*command, arguments->drives);
  add_log_flags(*command, arguments->reading);
  command->add_flag("--force", arguments->force, "write into a folder that is not empty");
  context.add_common_flags(*command);
  context.add_threads_flag(*command);
  context.add_option_flags(*command);
  context.add_robot_flag(*command);
  command->footer(kFooter);
  context.on_run(*command, [arguments, &context] {
    return is_mrclam_log(arguments->log) ? map_mrclam(*arguments, context)
                                         : run_map(*arguments, context);
  });
}

}  // namespace loopstone::app
