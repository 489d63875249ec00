#include "commands.hpp"
#include "loopstone/slam/map_options.hpp"
#include "result.hpp"

namespace loopstone::app {

void add_config_command(CLI::App& app, AppContext& context) {
  CLI::App* command = app.add_subcommand("config", "Show the effective options as TOML");
  context.add_option_flags(*command);
  context.on_run(*command, [&context] {
    auto options = context.load_options<MapOptions>();
    print_to_stdout(options_to_toml(list_options(options)));
    return kExitDone;
  });
}

}  // namespace loopstone::app
