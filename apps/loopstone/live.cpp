#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "commands.hpp"
#include "live_arguments.hpp"
#include "loopstone/base/error.hpp"
#include "word_flag.hpp"

namespace loopstone::app {

namespace {

constexpr const char* kFooter = R"(
A SOURCE is one of
  scip://HOST, scip:///dev/ttyACM0
                      a Hokuyo scanner; docs/devices.md has what can be said behind
  rplidar:///dev/ttyUSB0?baud=256000
                      an RPLIDAR
  tcp://HOST:PORT     a connection that is made to whoever tells messages there
  -, PIPE             the standard input, or a named pipe
  FILE                a log that somebody writes: from its beginning on, and on while it grows
  replay:LOG          a log at its own pace, or --speed times that
Streams and growing files hold MCAP (without chunks, or with small ones) or CARMEN's lines.

Ctrl-C ends the drive: the map is finished and written. Until then OUT/state.loopstone is saved every 30 s; --continue
goes on from it, on the same map, on another day or after a crash. Sources that are lost are waited for.

Examples:
  loopstone live --source scip://192.168.0.10 -o out         a laser and a laptop
  loopstone live --source tcp://robot.local:9000 -o out
  ros2 bag record -s mcap --storage-preset-profile fastwrite -o drive /scan /odom /tf /tf_static &
  loopstone live --source drive/drive_0.mcap -o out --poses -
  loopstone live --source replay:intel.clf --speed 20 -o out
  loopstone live --source tcp://robot.local:9000 --continue out -o out2
  loopstone live --source tcp://robot.local:9000 --map out --poses -)";

void check(const LiveArguments& arguments) {
  if (arguments.no_view && arguments.view != ViewFlags{})
    throw UsageError("--port, --listen, --token, --origin and --no-open are of the view");
  if (arguments.map.empty()) {
    if (arguments.out.empty()) throw UsageError("-o FOLDER: where is the map to be written?");
    if (!arguments.initial.empty()) throw UsageError("--initial is a place on the map of --map");
  } else {
    if (!arguments.from.empty())
      throw UsageError(
          "--map tells where the robot is, --continue goes on with a map: leave out one");
    if (arguments.odometry) throw UsageError("--odometry is of a map in the making");
  }
  if (arguments.initial.empty() && !arguments.initial_sigma.empty())
    throw UsageError("--initial-sigma says how good --initial is");
}

/// On a map that exists.
void add_place_flags(CLI::App& command, LiveArguments& arguments) {
  command
      .add_option("--map", arguments.map,
                  "make no map: tell where the robot is on this one, a map.yaml or a folder that "
                  "holds one")
      ->type_name("MAP");
  command
      .add_option("--initial", arguments.initial,
                  "about where it is on the map at first [m, m, rad] (default: anywhere)")
      ->type_name("X,Y,YAW");
  command
      .add_option("--initial-sigma", arguments.initial_sigma,
                  "standard deviations of that (default: 0.5,0.26)")
      ->type_name("M,RAD");
}

}  // namespace

void add_live_command(CLI::App& app, AppContext& context) {
  auto arguments = std::make_shared<LiveArguments>();
  CLI::App* command =
      app.add_subcommand("live", "Map what sensors tell now, or tell where the robot is");
  command
      ->add_option("--source", arguments->sources,
                   "where messages come from; may be given several times")
      ->type_name("SOURCE")
      ->allow_extra_args(false)
      ->required();
  command->add_option("-o,--out", arguments->out,
                      "folder for the results; made, or empty unless --force; with --map the "
                      "trajectory to write, FILE.tum, which may be left out");
  add_place_flags(*command, *arguments);
  command
      ->add_option("--continue", arguments->from,
                   "go on with the map in this folder, which stays as it is: the drive may begin "
                   "anywhere in its building")
      ->type_name("FOLDER");
  command->add_option("--speed", arguments->speed, "of logs that are replayed: 1 as recorded")
      ->type_name("X")
      ->check(CLI::Range(0.001, 1e6))
      ->capture_default_str();
  command
      ->add_option("--end-after", arguments->end_after_s,
                   "end the drive when nothing has come for so long [s]; 0 = never")
      ->type_name("SECONDS")
      ->check(CLI::NonNegativeNumber);
  command
      ->add_option("--checkpoint", arguments->checkpoint_s,
                   "save the state into OUT/state.loopstone so often [s]; 0 = only in the end")
      ->type_name("SECONDS")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--record", arguments->record, "also what comes, as a log to be mapped again")
      ->type_name("FILE.mcap");
  command
      ->add_option("--poses", arguments->poses,
                   "where the robot is, as soon as it is known: a line of JSON for each scan; - is "
                   "stdout")
      ->type_name("FILE");
  add_word_flag(*command, "--odometry", arguments->odometry,
                "used while it agrees with the laser, always, or not at all (default: check)");
  command->add_flag("--no-view", arguments->no_view, "nothing to look at in the browser");
  add_view_flags(*command, arguments->view);
  add_log_flags(*command, arguments->reading);
  command->add_flag("--force", arguments->force, "write into a folder that is not empty");
  context.add_common_flags(*command);
  context.add_threads_flag(*command);
  context.add_option_flags(*command);
  context.add_robot_flag(*command);
  command->footer(kFooter);
  context.on_run(*command, [arguments, &context] {
    check(*arguments);
    return arguments->map.empty() ? map_live(*arguments, context)
                                  : localize_live(*arguments, context);
  });
}

}  // namespace loopstone::app
