#include "loopstone/simulation/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "floor_files.hpp"
#include "interrupt.hpp"
#include "log_run.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/landmark_file.hpp"
#include "loopstone/formats/log_format_words.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/simulation/floor_pattern.hpp"
#include "loopstone/simulation/place_reflectors.hpp"
#include "output_path.hpp"
#include "result.hpp"
#include "simulated_folder.hpp"
#include "word_flag.hpp"

namespace loopstone::app {

namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string world;
  std::string output;
  std::optional<std::string> format;
  std::uint64_t seed = 1;
  std::optional<std::uint64_t> drive_seed;
  std::optional<std::size_t> start_place;
  bool force = false;
  std::optional<double> duration_s;
  std::optional<int> laps;
  std::optional<int> beams;
  std::optional<double> fov_deg;
  std::optional<double> scan_rate_hz;
  std::optional<double> max_range_m;
  std::optional<double> range_noise_m;
  std::optional<int> people;
  int reflectors = 0;
  std::optional<SimulatedOdometryFault> odometry_fault;
  std::optional<std::string> realism;
  bool rgbd = false;
  std::optional<std::string> floor;
  double floor_width_m = 4.0;
};

constexpr const char* kDefaultFormat = "ucsd";

/// The places of logs: "ucsd: DIR itself is the log; carmen: DIR/log.clf".
std::string log_places() {
  std::string text;
  for (const LogFormat& format : log_formats()) {
    if (!format.can_be_written()) continue;
    const SimulatedFolder folder{"DIR", &format};
    const bool is_file = format.place == LogPlace::kFile;
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", format.name,
                        is_file ? folder.log().path : "DIR itself is the log");
  }
  return text;
}

/// With commas, in indented lines of a help text.
std::string wrapped_names(const std::vector<std::string>& names) {
  std::string text;
  std::size_t column = 100;
  for (const std::string& name : names) {
    if (column + name.size() > 94) {
      text += "\n ";
      column = 1;
    }
    text += " " + name + (&name == &names.back() ? "" : ",");
    column += name.size() + 2;
  }
  return text;
}

std::string footer() {
  return fmt::format(R"(
WORLD is a map.yaml with its picture, as ROS map_server reads it, or one of
  office     about 1,000 m2: corridors, rooms with doors, furniture; loops
  campus     about 10,000 m2: six buildings joined by passages; loops of several hundred metres
  corridor   100 m straight between two rooms, nothing to hold on to on the way
  rooms      rows of rooms that are all alike
  warehouse  aisles between racks
  loops      a ring of long, nearly bare corridors, 100 to 400 m round, closed at one place
  wings      two floors of four wings, all alike, joined by one passage
  aisles     a warehouse whose aisles are equal to the last box
  hall       100 m x 80 m, a few columns: larger than a laser's reach
  outdoors   between buildings, with trees and cars; no wall around it

DIR then holds the log ({}), truth.tum
(map_T_robot at every scan), map.yaml and map.pgm (the true map) and world.json (what was
simulated). The same arguments give the same bytes. Wheels, gyro, laser, camera, faults, realism
and drive have more options: see --set, for example --set wheels.imbalance=0.002

--realism takes{}.
usual is what every robot has every day:{}.
world.json then has what was drawn, such as the laser's true mount, and when what was spoilt.

--reflectors N hangs reflectors on walls and columns along the way, five in view where N allows; scans
then have intensities (formats that hold them: mcap, bag, rosbag2), and landmarks.csv in DIR has the
reflectors' places, for loopstone localize --landmarks.

--rgbd adds the robot's RGB-D camera: pictures in dataRGBD, their stamps in Kinect20.npz, the
camera's true mount (not quite the robot file's) in world.json, and the true colours of the floor
at 1 cm in floor.png and floor.yaml, on the frame of the map, with the letters on it in
floor_letters.csv. Floors are
  tiles, carpet, wood, text (lines of it, letters mostly 5 cm high), mixed (a quarter of each,
  every 4 m) or a PNG picture, which is repeated.

Examples:
  loopstone simulate office -o sim --seed 1
  loopstone simulate campus -o campus --format carmen --people 20
  loopstone simulate office -o stuck --odometry-fault stuck --set faults.from_s=60 \
      --set faults.glass=0.1
  loopstone simulate warehouse -o lit --format mcap --reflectors 40
  loopstone simulate office -o seen --rgbd --floor text --duration 60
  loopstone simulate warehouse -o sick --format carmen --beams 180 --fov 179 \
      --scan-rate 5 --max-range 80
  loopstone simulate office -o unkind --realism usual,blocked,follower \
      --set realism.blocked.at_s=60)",
                     log_places(), wrapped_names(realism_names()), wrapped_names(usual_realism()));
}

/// A flag's value is held to the same rule as the option that it sets, and beats the file.
SimulationOptions options_of(const Arguments& arguments, const LogFormat& format,
                             const AppContext& context) {
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
  if (arguments.odometry_fault) options.faults.odometry = *arguments.odometry_fault;
  if (arguments.realism) choose_realism(options.realism, *arguments.realism);
  override_with("--fov", "laser.fov_rad", arguments.fov_deg, radians(1.0));
  override_with("--scan-rate", "laser.rate_hz", arguments.scan_rate_hz);
  override_with("--max-range", "laser.range_max_m", arguments.max_range_m);
  override_with("--range-noise", "laser.noise_m", arguments.range_noise_m);
  if (!problems.empty()) throw OptionsError(problems);
  options.odometry_poses = options.odometry_poses || !format.holds.wheel_ticks;
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

SimulatedFolder folder_of(const Arguments& arguments) {
  const LogFormat& format = log_format(arguments.format.value_or(kDefaultFormat));
  if (arguments.floor && !arguments.rgbd) {
    throw UsageError("--floor says what the camera sees; it needs --rgbd");
  }
  if (arguments.rgbd && !format.holds.rgbd_frames) {
    throw UsageError(fmt::format("{} can't hold pictures; --rgbd needs --format {}", format.noun,
                                 listed(writable_log_formats(&LogContents::rgbd_frames), "or")));
  }
  if (arguments.reflectors > 0 && !format.holds.intensities) {
    throw UsageError(fmt::format("{} can't hold intensities; --reflectors needs --format {}",
                                 format.noun,
                                 listed(writable_log_formats(&LogContents::intensities), "or")));
  }
  return {arguments.output, &format, arguments.rgbd};
}

/// Hangs the reflectors and says how many found a place.
World lit(World world, const Arguments& arguments, const RobotModel& robot,
          const SimulationOptions& options, const AppContext& context) {
  if (arguments.reflectors == 0) return world;
  world = with_reflectors(std::move(world), robot.footprint_radius_m, options.drive,
                          arguments.reflectors, arguments.seed);
  const auto placed = static_cast<int>(world.reflectors.size());
  if (placed == 0) {
    throw UsageError("--reflectors: no wall or column is seen from the robot's way in this world");
  }
  if (placed < arguments.reflectors) {
    context.warn(
        fmt::format("there was place for {} of {} reflectors, 1 m apart and seen from the "
                    "robot's way",
                    placed, arguments.reflectors));
  }
  return world;
}

Result result_of(const Arguments& arguments, const SimulatedFolder& folder, const World& world,
                 const SimulationSummary& summary) {
  Result result;
  result.add("world", "world", arguments.world)
      .add("seed", "seed", static_cast<std::int64_t>(arguments.seed))
      .add("log", "log", folder.log().path)
      .add("format", "format", std::string(folder.format->name))
      .add("floor_area_m2", "floor", world.floor_area_m2, "m2", 0)
      .add("route_length_m", "route", summary.route_length_m, "m", 1)
      .add("duration_s", "duration", summary.duration_s, "s", 1)
      .add("scans", "scans", summary.scans)
      .add("messages", "messages", summary.messages);
  if (!world.reflectors.empty()) result.add("reflectors", "reflectors", world.reflectors.size());
  if (arguments.rgbd) result.add("frames", "RGB-D frames", summary.frames);
  result.add("complete", "complete", summary.complete);
  return result;
}

/// The drive begins at one of the world's places, and goes from there to the others.
World started(World world, const Arguments& arguments) {
  if (!arguments.start_place) return world;
  const std::size_t place = *arguments.start_place;
  if (place == 0 || place > world.places.size()) {
    throw UsageError(
        fmt::format("--start-place: this world has the places 1 to {}", world.places.size()));
  }
  const Eigen::Vector2d& from = world.places[place - 1];
  world.map_T_start = {from.x(), from.y(), world.map_T_start.yaw};
  world.returns.clear();
  return world;
}

ExitCode run(const Arguments& arguments, AppContext& context) {
  const RobotModel robot = context.robot();
  const SimulatedFolder folder = folder_of(arguments);
  const SimulationOptions options = options_of(arguments, *folder.format, context);
  Outputs outputs(context, arguments.force);
  outputs.reads(arguments.world);
  outputs.reads(arguments.floor.value_or(""));
  outputs.add_folder("-o", arguments.output);
  outputs.check();
  RealismRecord record;
  World world = real_world(world_of(arguments, robot, context.memory()), options.realism,
                           arguments.seed, record);
  world = started(std::move(world), arguments);
  world = lit(std::move(world), arguments, robot, options, context);
  if (arguments.rgbd) world.floor = floor_of(arguments, context.memory());
  const HeldInterrupt held;
  outputs.prepare();
  remove_simulation(folder.path);

  SimulatedDrive drive = write_drive(folder, world, robot, options,
                                     arguments.drive_seed.value_or(arguments.seed), context);
  drive.summary.realism.facts.insert(drive.summary.realism.facts.begin(), record.facts.begin(),
                                     record.facts.end());
  write_truth(folder, world, drive.truth);
  if (!world.reflectors.empty())
    write_landmarks((folder.path / "landmarks.csv").string(), landmarks_of(world));
  for (const std::string& note : drive.notes) context.warn(note);
  const Result result = result_of(arguments, folder, world, drive.summary);
  write_description(folder, result.json(), robot, options, drive.summary.realism, arguments.floor);
  result.print(context);
  if (drive.summary.complete) return kExitDone;
  context.warn("interrupted: the log is of what was driven until then");
  return kExitInterrupted;
}

void add_drive_flags(CLI::App& command, Arguments& arguments) {
  command
      .add_option("--seed", arguments.seed, "of the world, the people and the noise (default: 1)")
      ->type_name("N");
  command
      .add_option("--drive-seed", arguments.drive_seed,
                  "of people and noise alone: another drive in the same world (default: that of "
                  "--seed)")
      ->type_name("N");
  command
      .add_option("--start-place", arguments.start_place,
                  "begin at the Nth of the world's places (default: where its route begins)")
      ->type_name("N");
  command
      .add_option("--duration", arguments.duration_s, "cut the drive (default: the whole route)")
      ->type_name("S");
  command.add_option("--laps", arguments.laps, "of the same route (default: 1)")->type_name("N");
}

void add_laser_flags(CLI::App& command, Arguments& arguments) {
  command.add_option("--beams", arguments.beams, "of a scan (default: 1081)")
      ->type_name("N")
      ->check(CLI::Range(2, 20000));
  command.add_option("--fov", arguments.fov_deg, "from the first beam to the last (default: 270)")
      ->type_name("DEG")
      ->check(CLI::Range(1.0, 360.0));
  command.add_option("--scan-rate", arguments.scan_rate_hz, "scans a second (default: 10)")
      ->type_name("HZ");
  command.add_option("--max-range", arguments.max_range_m, "of the laser (default: 30)")
      ->type_name("M");
  command
      .add_option("--range-noise", arguments.range_noise_m, "standard deviation (default: 0.01)")
      ->type_name("M");
}

/// What else is there, and what goes wrong.
void add_trouble_flags(CLI::App& command, Arguments& arguments) {
  command.add_option("--people", arguments.people, "who walk about (default: 0)")
      ->type_name("N")
      ->check(CLI::Range(0, 1000));
  command
      .add_option("--reflectors", arguments.reflectors,
                  "that hang along the way, in scans with intensities (default: 0)")
      ->type_name("N")
      ->check(CLI::Range(0, 10000));
  add_word_flag(command, "--odometry-fault", arguments.odometry_fault,
                "what is wrong with wheels and gyro (default: none)");
  command
      .add_option("--realism", arguments.realism,
                  "how the world is less kind than a simulation: effects with commas between them, "
                  "usual, all or none (default: none)")
      ->type_name("NAME,...");
}

void add_camera_flags(CLI::App& command, Arguments& arguments) {
  command.add_flag("--rgbd", arguments.rgbd, "take pictures with the robot's RGB-D camera");
  command
      .add_option("--floor", arguments.floor,
                  "what the camera sees the floor covered with (default: mixed)")
      ->type_name("NAME|FILE.png");
  command
      .add_option("--floor-width", arguments.floor_width_m,
                  "of the picture FILE.png before it repeats (default: 4)")
      ->type_name("M")
      ->check(CLI::Range(0.01, 1000.0));
}

}  // namespace

void add_simulate_command(CLI::App& app, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("simulate", "Make a log whose truth is known");
  command->add_option("WORLD", arguments->world, "a built-in world or a map.yaml")->required();
  command->add_option("-o,--output", arguments->output, "folder to write")
      ->type_name("DIR")
      ->required();
  add_format_flag(*command, arguments->format,
                  fmt::format("of the log (default: {})", kDefaultFormat));
  add_drive_flags(*command, *arguments);
  add_laser_flags(*command, *arguments);
  add_trouble_flags(*command, *arguments);
  add_camera_flags(*command, *arguments);
  command->add_flag("--force", arguments->force, "write into DIR even if it holds something");
  context.add_robot_flag(*command);
  context.add_option_flags(*command);
  context.add_common_flags(*command);
  command->footer(footer());
  context.on_run(*command, [arguments, &context] { return run(*arguments, context); });
}

}  // namespace loopstone::app
