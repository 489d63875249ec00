#include <fmt/format.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "commands.hpp"
#include "floor_run.hpp"
#include "interrupt.hpp"
#include "log_run.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/report/peak_memory.hpp"
#include "loopstone/report/texture_outputs.hpp"
#include "output_path.hpp"

namespace loopstone::app {

namespace {

struct Arguments {
  std::string log;
  std::string trajectory;
  std::string out;
  std::string map;
  bool cloud = false;
  bool force = false;
  LogFlags reading;
};

/// The options under the names that `loopstone map` gives them.
struct Options {
  TextureOptions texture{};
};

template <typename Visitor>
void visit_options(Options& options, Visitor&& visit) {
  visit.group("texture", options.texture);
}

constexpr const char* kFooter = R"(
The trajectory is map_T_robot as TUM text, from `loopstone map`, `loopstone localize` or elsewhere; its stamps are on
the log's clock. The robot file tells lenses and mount of the camera; roll, pitch and height of the mount and an
offset of the camera's clock are estimated, reported and corrected.

OUT then holds texture.png with texture.yaml (frame as map.yaml) and texture.pgw (for GIS programs), coverage.png (white:
seen, grey: filled, black: unknown), texture_map.png to look at, summary.json and options.toml.

Examples:
  loopstone texture sim --trajectory sim/truth.tum -o floor --map sim/map.yaml
  loopstone texture ucsd#20 --trajectory out/trajectory.tum -o floor --set texture.resolution_m=0.005 --cloud)";

/// The walls, for the picture.
OccupancyMap walls_of(const std::string& path, const MemoryBudget& budget) {
  if (path.empty()) return {};
  const CellStates cells = read_ros_map(path, budget, sizeof(float) + 1);
  OccupancyMap map{Grid<float>(cells.frame(), 0.0F), Grid<std::uint8_t>(cells.frame(), 0)};
  for (std::size_t i = 0; i < cells.cells().size(); ++i) {
    const std::int8_t state = cells.cells()[i];
    if (state < 0) continue;
    map.observed.cells()[i] = 1;
    map.log_odds.cells()[i] = state > 50 ? 4.0F : -4.0F;
  }
  return map;
}

Outputs outputs_of(const Arguments& arguments, const AppContext& context) {
  Outputs outputs(context, arguments.force);
  outputs.reads_log(arguments.log);
  outputs.reads(arguments.trajectory);
  outputs.reads(arguments.map);
  outputs.add_folder("-o", arguments.out);
  return outputs;
}

/// What a log holds for the colour of the floor.
struct Recording {
  CameraFrames camera{};
  LeftOut left_out{};
};

/// Throws DataError when there are no pictures in it, ReadingStopped when the user interrupts.
Recording read_recording(LogReader& reader, const std::string& path, const AppContext& context) {
  Recording recording;
  LeftOutCounter counter(reader);
  while (const auto message = reader.next()) {
    recording.camera.take(*message);
    counter.add(*message);
    if (interrupted()) throw ReadingStopped();
  }
  recording.camera.take_pictures(reader);
  recording.left_out = counter.left_out();
  judge_left_out(recording.left_out, path, context);
  if (recording.camera.complete() == 0) {
    throw DataError({path},
                    "there are no RGB-D frames with depth and colour in it; `loopstone info` shows "
                    "what there is");
  }
  if (!context.robot_given() && !recording.camera.fault().empty()) {
    throw DataError({path}, recording.camera.fault() + "; --robot FILE can tell it");
  }
  return recording;
}

/// Throws DataError when not one frame could be put on the floor.
void require_used_frames(const FloorTexture& texture, const Arguments& arguments) {
  const TextureStatistics& s = texture.statistics;
  if (!texture.complete) return;
  if (s.frames_without_pose == s.frames) {
    throw DataError({arguments.trajectory},
                    "has no pose at the time of any frame; is it of this log, and on its clock?");
  }
  if (s.frames_used == 0 && s.frames_unreadable > 0) {
    throw DataError({arguments.log}, "none of its pictures can be used, as the warnings say");
  }
}

void print_table(const FloorTexture& texture, const RunInfo& info, const std::string& out,
                 const AppContext& context) {
  Result table;
  add_texture_rows(texture, table);
  table.add_row("time",
                fmt::format("{:.2f} s, {:.0f} frames a second", info.wall_time_s,
                            static_cast<double>(texture.statistics.frames) / info.wall_time_s));
  table.add_row("picture", out + "/texture_map.png");
  table.print(context);
}

ExitCode run(const Arguments& arguments, const AppContext& context) {
  const auto start = std::chrono::steady_clock::now();
  Options options = context.load_options<Options>();
  if (arguments.cloud) gather_cloud(options.texture);

  const LogFiles log_files(arguments.log);
  const Outputs outputs = outputs_of(arguments, context);
  outputs.check(least_bytes_of_results(log_files.bytes()));
  const Trajectory trajectory = read_tum(arguments.trajectory, context.memory());
  const OccupancyMap map = walls_of(arguments.map, context.memory());
  ProblemPrinter print_problem(context);
  const auto reader =
      open_log(arguments.log, log_options(arguments.reading, context, &print_problem));
  tell_choices(*reader, context);
  outputs.prepare();
  const RobotModel robot = robot_of(*reader, context);

  ProgressDisplay display(context);
  const Recording recording = read_recording(*reader, arguments.log, context);
  const HeldInterrupt held;
  FloorTexture texture =
      colour_floor(recording.camera, trajectory, robot, options.texture, context, display);
  for (const std::string& change : log_files.changes()) {
    context.warn(change);
    texture.warnings.push_back(change);
  }
  require_used_frames(texture, arguments);

  RunInfo info = run_info(arguments.log, recording.left_out, arguments.force, context);
  info.options_toml = options_to_toml(list_options(options));
  info.wall_time_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  write_texture_outputs(texture, map, trajectory, info, arguments.out);
  info.peak_memory_bytes = peak_memory_bytes();
  if (context.json()) {
    print_to_stdout(format_texture_summary(texture, info));
  } else {
    print_table(texture, info, arguments.out, context);
  }
  if (!texture.complete) context.warn("interrupted: the colours are of what was seen until then");
  return texture.complete ? kExitDone : kExitInterrupted;
}

}  // namespace

void add_texture_command(CLI::App& app, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("texture", "Put the colour of the floor on the map, from RGB-D");
  command->add_option("LOG", arguments->log, "a log with RGB-D frames")->required();
  command->add_option("--trajectory", arguments->trajectory, "where the robot was")
      ->type_name("FILE.tum")
      ->required();
  command
      ->add_option("-o,--out", arguments->out,
                   "folder for the results; made, or empty unless --force")
      ->required();
  command->add_option("--map", arguments->map, "walls for the picture")->type_name("MAP.yaml");
  command->add_flag("--cloud", arguments->cloud,
                    "also cloud.ply: everything the camera saw, in colour");
  arguments->reading.pictures = true;
  add_log_flags(*command, arguments->reading);
  command->add_flag("--force", arguments->force, "write into a folder that is not empty");
  context.add_robot_flag(*command);
  context.add_threads_flag(*command);
  context.add_option_flags(*command);
  context.add_common_flags(*command);
  command->footer(kFooter);
  context.on_run(*command, [arguments, &context] { return run(*arguments, context); });
}

}  // namespace loopstone::app
