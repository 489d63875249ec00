#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "commands.hpp"
#include "live_arguments.hpp"
#include "live_flags.hpp"

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
  add_live_map_flags(*command, *arguments);
  command->add_option("--speed", arguments->speed, "of logs that are replayed: 1 as recorded")
      ->type_name("X")
      ->check(CLI::Range(0.001, 1e6))
      ->capture_default_str();
  add_live_flags(*command, *arguments, context);
  command->footer(kFooter);
  context.on_run(*command, [arguments, &context] { return run_live(*arguments, context); });
}

}  // namespace loopstone::app
