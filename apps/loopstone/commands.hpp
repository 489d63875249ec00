#pragma once

#include <CLI/CLI.hpp>

#include "app.hpp"

namespace loopstone::app {

// One function for each subcommand, each in the file of its name.
void add_calibrate_command(CLI::App& app, AppContext& context);
void add_config_command(CLI::App& app, AppContext& context);
void add_convert_command(CLI::App& app, AppContext& context);
void add_edit_command(CLI::App& app, AppContext& context);
void add_evaluate_command(CLI::App& app, AppContext& context);
void add_export_command(CLI::App& app, AppContext& context);
void add_info_command(CLI::App& app, AppContext& context);
void add_live_command(CLI::App& app, AppContext& context);
void add_localize_command(CLI::App& app, AppContext& context);
void add_map_command(CLI::App& app, AppContext& context);
void add_match_command(CLI::App& app, AppContext& context);
void add_odometry_command(CLI::App& app, AppContext& context);
void add_optimize_command(CLI::App& app, AppContext& context);
void add_relocalize_command(CLI::App& app, AppContext& context);
void add_texture_command(CLI::App& app, AppContext& context);
void add_site_command(CLI::App& app, AppContext& context);
void add_simulate_command(CLI::App& app, AppContext& context);
void add_view_command(CLI::App& app, AppContext& context);

}  // namespace loopstone::app
