#include <memory>

#include "commands.hpp"
#include "loopstone/localization/landmark_tracking_options.hpp"
#include "loopstone/localization/localization_options.hpp"
#include "loopstone/slam/map_options.hpp"
#include "map_pipeline.hpp"
#include "result.hpp"

namespace loopstone::app {

namespace {

template <typename Options>
std::string effective_options(const AppContext& context) {
  auto options = context.load_options<Options>();
  return options_to_toml(list_options(options));
}

}  // namespace

void add_config_command(CLI::App& app, AppContext& context) {
  auto of = std::make_shared<std::string>("map");
  CLI::App* command = app.add_subcommand("config", "Show the effective options as TOML");
  command
      ->add_option("COMMAND", *of,
                   "whose options; landmarks: of localize --landmarks; landmark_map: of "
                   "map --landmarks")
      ->type_name("map|localize|landmarks|landmark_map")
      ->check(CLI::IsMember({"map", "localize", "landmarks", "landmark_map"}))
      ->capture_default_str();
  context.add_option_flags(*command);
  context.on_run(*command, [of, &context] {
    print_to_stdout(*of == "landmarks"      ? effective_options<LandmarkTrackingOptions>(context)
                    : *of == "landmark_map" ? effective_options<LandmarkMapOptions>(context)
                    : *of == "localize"     ? effective_options<LocalizationOptions>(context)
                                            : effective_options<MapOptions>(context));
    return kExitDone;
  });
}

}  // namespace loopstone::app
