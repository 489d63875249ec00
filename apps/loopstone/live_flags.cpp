#include "live_flags.hpp"

#include <CLI/CLI.hpp>

#include "log_flags.hpp"
#include "loopstone/base/error.hpp"
#include "word_flag.hpp"

namespace loopstone::app {

namespace {

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
                  "make no map: tell where the robot is on this one, a map.yaml, a folder that "
                  "holds one, or a site")
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

void add_live_map_flags(CLI::App& command, LiveArguments& arguments) {
  command.add_option("-o,--out", arguments.out,
                     "folder for the results; made, or empty unless --force; with --map the "
                     "trajectory to write, FILE.tum, which may be left out");
  add_place_flags(command, arguments);
  command
      .add_option("--continue", arguments.from,
                  "go on with the map in this folder, which stays as it is: the drive may begin "
                  "anywhere in its building")
      ->type_name("FOLDER");
}

void add_live_flags(CLI::App& command, LiveArguments& arguments, AppContext& context) {
  command
      .add_option("--end-after", arguments.end_after_s,
                  "end the drive when nothing has come for so long [s]; 0 = never")
      ->type_name("SECONDS")
      ->check(CLI::NonNegativeNumber);
  command
      .add_option("--checkpoint", arguments.checkpoint_s,
                  "save the state into OUT/state.loopstone so often [s]; 0 = only in the end")
      ->type_name("SECONDS")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command.add_option("--record", arguments.record, "also what comes, as a log to be mapped again")
      ->type_name("FILE.mcap");
  command
      .add_option("--poses", arguments.poses,
                  "where the robot is, as soon as it is known: a line of JSON for each scan; - is "
                  "stdout")
      ->type_name("FILE");
  add_word_flag(command, "--odometry", arguments.odometry,
                "used while it agrees with the laser, always, or not at all (default: check)");
  command.add_flag("--no-view", arguments.no_view, "nothing to look at in the browser");
  add_view_flags(command, arguments.view);
  add_log_flags(command, arguments.reading);
  command.add_flag("--force", arguments.force, "write into a folder that is not empty");
  context.add_common_flags(command);
  context.add_threads_flag(command);
  context.add_option_flags(command);
  context.add_robot_flag(command);
}

ExitCode run_live(const LiveArguments& arguments, const AppContext& context) {
  check(arguments);
  return arguments.map.empty() ? map_live(arguments, context) : localize_live(arguments, context);
}

}  // namespace loopstone::app
