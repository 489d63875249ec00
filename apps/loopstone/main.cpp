#include <fmt/format.h>

#include <algorithm>

#include "commands.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_format_words.hpp"
#include "loopstone/version.hpp"
#include "program.hpp"

namespace loopstone::app {

namespace {

std::string footer() {
  return fmt::format(R"(
Examples:
  loopstone info LOG                               what is in a log, and what is odd about it
  loopstone map LOG -o out                         map, trajectory, report: open out/report.html
  loopstone live --source tcp://robot:9000 -o out  a map of what the sensors tell now, in the browser while it grows
  loopstone view out                               the same in the browser, with a robot that drives on it
  loopstone localize LOG --map out -o w.tum --global  where a robot was on that map, and how sure that is
  loopstone simulate office -o sim --seed 1        a log whose truth is known
  loopstone map sim -o out && loopstone evaluate --estimate out/trajectory.tum --reference sim/truth.tum

A LOG is {}.
Exit codes: 0 done, 1 bad data, 2 bad usage or options, 3 a --require bound was missed, 130 interrupted.
`loopstone COMMAND --help` explains a command.)",
                     what_a_log_is());
}

void add_commands(CLI::App& app, AppContext& context) {
  // In the order in which a user meets them.
  add_info_command(app, context);
  add_map_command(app, context);
  add_live_command(app, context);
  add_view_command(app, context);
  add_edit_command(app, context);
  add_site_command(app, context);
  add_export_command(app, context);
  add_calibrate_command(app, context);
  add_texture_command(app, context);
  add_localize_command(app, context);
  add_relocalize_command(app, context);
  add_match_command(app, context);
  add_odometry_command(app, context);
  add_optimize_command(app, context);
  add_evaluate_command(app, context);
  add_simulate_command(app, context);
  add_convert_command(app, context);
  add_config_command(app, context);
}

/// CLI11 only says that a command is missing; a typing error deserves the right word.
void refuse_unknown_command(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  const std::string word = argv[1];
  std::vector<std::string> known;
  for (const CLI::App* command : app.get_subcommands({})) known.push_back(command->get_name());
  if (std::find(known.begin(), known.end(), word) != known.end()) return;
  const std::string nearest = nearest_key(word, known);
  throw UsageError(
      "there is no command " + word +
      (nearest.empty() ? "; `loopstone --help` lists all" : "; did you mean " + nearest + "?"));
}

int run_loopstone(int argc, char** argv) {
  begin_program("loopstone");
  CLI::App app{"Loopstone turns the log of a robot with a 2D laser scanner into a map.",
               "loopstone"};
  AppContext context;
  context.set_command_line("loopstone", argc, argv);
  app.set_version_flag("--version", "loopstone " + std::string(kVersion));
  app.require_subcommand(1);
  add_commands(app, context);
  app.footer(footer());  // after the commands, which would inherit it

  return run_program(app, [&] {
    refuse_unknown_command(app, argc, argv);
    app.parse(argc, argv);
    return context.run();
  });
}

}  // namespace

}  // namespace loopstone::app

int main(int argc, char** argv) { return loopstone::app::run_loopstone(argc, argv); }
