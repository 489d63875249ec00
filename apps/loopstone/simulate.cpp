#include "loopstone/simulation/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <system_error>

#include "commands.hpp"
#include "floor_files.hpp"
#include "interrupt.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/formats/text_file.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/formats/ucsd_pictures.hpp"
#include "loopstone/geometry/roll_pitch_yaw.hpp"
#include "loopstone/simulation/floor_pattern.hpp"
#include "loopstone/version.hpp"
#include "output_path.hpp"
#include "progress_display.hpp"
#include "result.hpp"

namespace loopstone::app {

namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string world;
  std::string output;
  std::string format = "ucsd";
  std::uint64_t seed = 1;
  bool force = false;
  std::optional<double> duration_s;
  std::optional<int> laps;
  std::optional<int> beams;
  std::optional<double> fov_deg;
  std::optional<double> scan_rate_hz;
  std::optional<double> max_range_m;
  std::optional<double> range_noise_m;
  std::optional<int> people;
  std::optional<std::string> odometry_fault;
  bool rgbd = false;
  std::optional<std::string> floor;
  double floor_width_m = 4.0;
};

constexpr const char* kFooter = R"(
WORLD is a map.yaml with its picture, as ROS map_server reads it, or one of
  office     about 1,000 m2: corridors, rooms with doors, furniture; loops
  campus     about 10,000 m2: six buildings joined by passages; loops of several hundred metres
  corridor   100 m straight between two rooms, nothing to hold on to on the way
  rooms      rows of rooms that are all alike
  warehouse  aisles between racks

DIR then holds the log (ucsd: DIR itself is the log; carmen: DIR/log.clf), truth.tum (map_T_robot at every scan),
map.yaml and map.pgm (the true map) and world.json (what was simulated). The same arguments give the same bytes.
Wheels, gyro, laser, camera, faults and drive have more options: see --set, for example --set wheels.imbalance=0.002

--rgbd adds the robot's RGB-D camera: pictures in dataRGBD, their stamps in Kinect20.npz, the camera's true mount (not quite
the robot file's) in world.json, and the true colours of the floor at 1 cm in floor.png and floor.yaml, on the frame of the
map, with the letters on it in floor_letters.csv. Floors are
  tiles, carpet, wood, text (lines of it, letters mostly 5 cm high), mixed (a quarter of each, every 4 m)
  or a PNG picture, which is repeated.

Examples:
  loopstone simulate office -o sim --seed 1
  loopstone simulate campus -o campus --format carmen --people 20
  loopstone simulate office -o stuck --odometry-fault stuck --set faults.from_s=60 --set faults.glass=0.1
  loopstone simulate office -o seen --rgbd --floor text --duration 60
  loopstone simulate warehouse -o sick --format carmen --beams 180 --fov 179 --scan-rate 5 --max-range 80)";

/// A flag's value is held to the same rule as the option that it sets, and beats the file.
SimulationOptions options_of(const Arguments& arguments, const AppContext& context) {
  auto options = context.load_options<SimulationOptions>();
  const std::vector<OptionEntry> entries = list_options(options);
  std::vector<OptionProblem> problems;
  const auto override_with = [&](const char* flag, const char* key, const auto& value,
                                 double factor = 1.0) {
    if (value) override_option(entries, flag, fmt::format("{}={}", key, *value * factor), problems);
  };
  override_with("--duration", "duration_s", arguments.duration_s);
  override_with("--laps", "drive.laps", arguments.laps);
  if (arguments.beams) options.laser.beams = *arguments.beams;
  if (arguments.people) options.people = *arguments.people;
  if (arguments.odometry_fault) {
    override_option(entries, "--odometry-fault", "faults.odometry=" + *arguments.odometry_fault,
                    problems);
  }
  override_with("--fov", "laser.fov_rad", arguments.fov_deg, radians(1.0));
  override_with("--scan-rate", "laser.rate_hz", arguments.scan_rate_hz);
  override_with("--max-range", "laser.range_max_m", arguments.max_range_m);
  override_with("--range-noise", "laser.noise_m", arguments.range_noise_m);
  if (!problems.empty()) throw OptionsError(problems);
  if (arguments.format == "carmen") options.odometry_poses = true;
  return options;
}

std::shared_ptr<const FloorPattern> floor_of(const Arguments& arguments,
                                             const MemoryBudget& budget) {
  const std::string name = arguments.floor.value_or("mixed");
  std::error_code ignored;
  if (!name.ends_with(".png") && !fs::exists(name, ignored)) {
    return std::make_shared<const FloorPattern>(make_floor(name, arguments.seed));
  }
  return std::make_shared<const FloorPattern>(
      make_floor(as_colours(read_image(name, budget)), arguments.floor_width_m));
}

World world_of(const Arguments& arguments, const RobotModel& robot, const MemoryBudget& budget) {
  const auto& names = world_names();
  std::error_code ignored;
  const bool is_built_in = std::find(names.begin(), names.end(), arguments.world) != names.end();
  const bool is_file = fs::exists(arguments.world, ignored) || arguments.world.ends_with(".yaml");
  if (is_built_in || !is_file) return make_world(arguments.world, arguments.seed);
  const CellStates cells = read_ros_map(arguments.world, budget);
  return make_world(cells, arguments.world, robot.footprint_radius_m);
}

nlohmann::ordered_json to_json(const SimulationOptions& options) {
  SimulationOptions copy = options;
  auto json = nlohmann::ordered_json::object();
  for (const OptionEntry& entry : list_options(copy)) {
    auto* at = &json;
    std::size_t from = 0;
    for (std::size_t dot = entry.key.find('.'); dot != entry.key.npos;
         dot = entry.key.find('.', from)) {
      at = &(*at)[entry.key.substr(from, dot - from)];
      from = dot + 1;
    }
    std::visit([&](const auto* value) { (*at)[entry.key.substr(from)] = *value; }, entry.value);
  }
  return json;
}

nlohmann::ordered_json to_json(const RobotModel& robot) {
  const Pose2 robot_T_lidar =
      robot.lidars.empty() ? LidarMount{}.robot_T_lidar : robot.lidars.front().robot_T_lidar;
  return {{"name", robot.name},
          {"footprint_radius_m", robot.footprint_radius_m},
          {"metres_per_count", robot.wheels.metres_per_count},
          {"track_width_m", robot.wheels.track_width_m},
          {"robot_T_lidar",
           {{"x_m", robot_T_lidar.x}, {"y_m", robot_T_lidar.y}, {"yaw_rad", robot_T_lidar.yaw}}}};
}

/// The camera as it truly was, which the robot's file does not say.
nlohmann::ordered_json to_json(const CameraModel& camera, const SimulatedCamera& options) {
  const Eigen::Vector3d angles = to_roll_pitch_yaw(camera.robot_T_camera);
  const Eigen::Vector3d& position = camera.robot_T_camera.translation;
  return {{"robot_T_camera",
           {{"x_m", position.x()},
            {"y_m", position.y()},
            {"z_m", position.z()},
            {"roll_rad", angles.x()},
            {"pitch_rad", angles.y()},
            {"yaw_rad", angles.z()}}},
          {"clock_offset_s", options.clock_offset_s}};
}

struct Simulated {
  SimulationSummary summary;
  Trajectory truth;
  std::vector<std::string> notes;
};

Simulated write_log(const World& world, const RobotModel& robot, const SimulationOptions& options,
                    const Arguments& arguments, const std::string& log_path,
                    const AppContext& context) {
  const auto writer = create_log(log_path, arguments.format, robot);
  ProgressDisplay display(context);
  Simulated simulated;
  SimulationSink sink;
  sink.message = [&](const SensorMessage& message) { writer->write(message); };
  UcsdPictures pictures{log_path};
  pictures.holds_disparity = robot.camera.encoding.kind == "disparity";
  if (arguments.rgbd) {
    pictures.make_folders();
    sink.frame = [&](const SimulatedFrame& frame) -> RgbdFrame {
      pictures.write_depth(frame.index, frame.depth);
      pictures.write_colour(frame.index, frame.colour);
      return {frame.depth_stamp, frame.colour_stamp, pictures.colour_path(frame.index),
              pictures.depth_path(frame.index)};
    };
  }
  sink.truth = [&](const StampedPose2& pose) { simulated.truth.append(pose.stamp, pose.pose); };
  std::int64_t scans = 0;
  sink.progress = [&](double done_s, double total_s) {
    Progress progress{"simulating", std::llround(done_s), std::llround(total_s), ++scans};
    progress.recorded_s = done_s;
    return display.show(progress);
  };
  simulated.summary = simulate(world, robot, options, arguments.seed, sink);
  writer->finish();
  simulated.notes = writer->notes();
  ProgressDisplay::clear_line();
  return simulated;
}

/// An older simulation goes, its description first: whoever ends this run leaves no mixture of both that looks whole.
void remove_simulation(const fs::path& folder) {
  std::error_code error;
  if (!fs::remove(folder / "world.json", error)) return;
  for (const char* const name : {"truth.tum", "map.yaml", "map.pgm", "log.clf", "Encoders20.npz",
                                 "Imu20.npz", "Hokuyo20.npz", "Kinect20.npz", "Odometry20.npz",
                                 "floor.png", "floor.yaml", "floor_letters.csv"}) {
    fs::remove(folder / name, error);
  }
  for (const char* const pictures : {"RGB20", "Disparity20", "Depth20"}) {
    fs::remove_all(folder / "dataRGBD" / pictures, error);
  }
}

ExitCode run(const Arguments& arguments, AppContext& context) {
  const RobotModel robot = context.robot();
  const SimulationOptions options = options_of(arguments, context);
  if (arguments.floor && !arguments.rgbd) {
    throw UsageError("--floor says what the camera sees; it needs --rgbd");
  }
  if (arguments.rgbd && arguments.format != "ucsd") {
    throw UsageError("CARMEN text can't hold pictures; --rgbd needs --format ucsd");
  }
  Outputs outputs(context, arguments.force);
  outputs.reads(arguments.world);
  outputs.reads(arguments.floor.value_or(""));
  outputs.add_folder("-o", arguments.output);
  outputs.check();
  World world = world_of(arguments, robot, context.memory());
  if (arguments.rgbd) world.floor = floor_of(arguments, context.memory());
  const HeldInterrupt held;
  outputs.prepare();
  const fs::path folder(arguments.output);
  remove_simulation(folder);
  const std::string log_path =
      arguments.format == "carmen" ? (folder / "log.clf").string() : arguments.output;

  const Simulated simulated = write_log(world, robot, options, arguments, log_path, context);
  const SimulationSummary& summary = simulated.summary;
  write_tum((folder / "truth.tum").string(), simulated.truth);
  const CellStates map = true_map(world);
  write_ros_map((folder / "map.yaml").string(), map);
  if (world.floor) write_floor(folder, *world.floor, map.frame());
  for (const std::string& note : simulated.notes) context.warn(note);

  Result result;
  result.add("world", "world", arguments.world)
      .add("seed", "seed", static_cast<std::int64_t>(arguments.seed))
      .add("log", "log", log_path)
      .add("format", "format", arguments.format)
      .add("floor_area_m2", "floor", world.floor_area_m2, "m2", 0)
      .add("route_length_m", "route", summary.route_length_m, "m", 1)
      .add("duration_s", "duration", summary.duration_s, "s", 1)
      .add("scans", "scans", summary.scans)
      .add("messages", "messages", summary.messages);
  if (arguments.rgbd) result.add("frames", "RGB-D frames", summary.frames);
  result.add("complete", "complete", summary.complete);
  nlohmann::ordered_json description = result.json();
  description["log"] =
      arguments.format == "carmen" ? "log.clf" : ".";  // from here, so that a folder can be moved
  description["robot"] = to_json(robot);
  if (arguments.rgbd) {
    description["floor"] = arguments.floor.value_or("mixed");
    description["camera"] = to_json(true_camera(robot.camera, options.camera), options.camera);
  }
  description["options"] = to_json(options);
  description["version"] = std::string(kVersion);
  write_text_file((folder / "world.json").string(), description.dump(2) + "\n");
  result.print(context);
  if (!summary.complete) context.warn("interrupted: the log is of what was driven until then");
  return summary.complete ? kExitDone : kExitInterrupted;
}

}  // namespace

void add_simulate_command(CLI::App& app, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("simulate", "Make a log whose truth is known");
  command->add_option("WORLD", arguments->world, "a built-in world or a map.yaml")->required();
  command->add_option("-o,--output", arguments->output, "folder to write")
      ->type_name("DIR")
      ->required();
  command->add_option("--format", arguments->format, "of the log (default: ucsd)")
      ->type_name("ucsd|carmen")
      ->check(CLI::IsMember({"ucsd", "carmen"}));
  command
      ->add_option("--seed", arguments->seed, "of the world, the people and the noise (default: 1)")
      ->type_name("N");
  command
      ->add_option("--duration", arguments->duration_s, "cut the drive (default: the whole route)")
      ->type_name("S");
  command->add_option("--laps", arguments->laps, "of the same route (default: 1)")->type_name("N");
  command->add_option("--beams", arguments->beams, "of a scan (default: 1081)")
      ->type_name("N")
      ->check(CLI::Range(2, 20000));
  command->add_option("--fov", arguments->fov_deg, "from the first beam to the last (default: 270)")
      ->type_name("DEG")
      ->check(CLI::Range(1.0, 360.0));
  command->add_option("--scan-rate", arguments->scan_rate_hz, "scans a second (default: 10)")
      ->type_name("HZ");
  command->add_option("--max-range", arguments->max_range_m, "of the laser (default: 30)")
      ->type_name("M");
  command
      ->add_option("--range-noise", arguments->range_noise_m, "standard deviation (default: 0.01)")
      ->type_name("M");
  command->add_option("--people", arguments->people, "who walk about (default: 0)")
      ->type_name("N")
      ->check(CLI::Range(0, 1000));
  command
      ->add_option("--odometry-fault", arguments->odometry_fault,
                   "what is wrong with wheels and gyro (default: none)")
      ->type_name("none|missing|stuck|scaled|mirrored|lagging|jumping");
  command->add_flag("--rgbd", arguments->rgbd, "take pictures with the robot's RGB-D camera");
  command
      ->add_option("--floor", arguments->floor,
                   "what the camera sees the floor covered with (default: mixed)")
      ->type_name("NAME|FILE.png");
  command
      ->add_option("--floor-width", arguments->floor_width_m,
                   "of the picture FILE.png before it repeats (default: 4)")
      ->type_name("M")
      ->check(CLI::Range(0.01, 1000.0));
  command->add_flag("--force", arguments->force, "write into DIR even if it holds something");
  context.add_robot_flag(*command);
  context.add_option_flags(*command);
  context.add_common_flags(*command);
  command->footer(kFooter);
  context.on_run(*command, [arguments, &context] { return run(*arguments, context); });
}

}  // namespace loopstone::app
