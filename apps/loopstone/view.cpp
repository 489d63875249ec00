#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "result.hpp"
#include "view_folder.hpp"
#include "view_log.hpp"
#include "view_request.hpp"

namespace loopstone::app {

std::string short_name(const std::string& path) {
  const std::filesystem::path whole(path);
  // "out/" is called out.
  const std::string name = whole.filename().string();
  return name.empty() ? whole.parent_path().filename().string() : name;
}

void tell_address(const LiveView& view, const AppContext& context) {
  Result result;
  result.add("url", "view", view.url());
  result.print(context);
}

void add_view_command(CLI::App& app, AppContext& context) {
  auto request = std::make_shared<ViewRequest>();
  CLI::App* command = app.add_subcommand(
      "view", "Show a map in the browser: a finished one, or a log as it is mapped");
  command
      ->add_option("WHAT", request->what,
                   "the folder that `loopstone map` left, or a log, which is mapped while it is "
                   "replayed")
      ->required();
  command
      ->add_option("--speed", request->speed, "of the replay: 1 as recorded, 0 as fast as it goes")
      ->type_name("X")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command
      ->add_option("--log", request->log,
                   "of a folder: the log whose scans are shown (default: the one that it was made "
                   "of)")
      ->type_name("LOG");
  command->add_flag("--edit", request->edit,
                    "of a folder that `map --keep-state` left: the map may be put right by hand in "
                    "the browser");
  command
      ->add_option("--edits", request->edits,
                   "of --edit: where the edits are saved (default: WHAT.edits.toml)")
      ->type_name("FILE.toml");
  add_view_flags(*command, request->view);
  add_cut_flags(*command, request->cut);
  add_log_flags(*command, request->reading);
  context.add_common_flags(*command);
  context.add_threads_flag(*command);
  context.add_option_flags(*command);
  context.add_robot_flag(*command);
  command->footer(R"(
Prints an address for the browser. Foxglove and Lichtblick connect to the same one, as a "Foxglove
WebSocket". Ctrl-C ends it. Only this machine can connect unless --listen and --token say otherwise.

Examples:
  loopstone view out
  loopstone view out --edit                  then: loopstone edit out --edits out.edits.toml -o out2
  loopstone view intel.clf --speed 20
  loopstone map intel.clf -o out --view)");
  context.on_run(*command, [request, &context] {
    return is_map_folder(request->what) ? view_folder(*request, context)
                                        : view_log(*request, context);
  });
}

}  // namespace loopstone::app
