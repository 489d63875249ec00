#pragma once

#include <string>

#include "app.hpp"
#include "loopstone/report/edited_folder.hpp"
#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/slam/map_editor.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/settled_map.hpp"

// A folder of results as something that can be edited: its state.

namespace loopstone::app {

/// What the map was made by.
struct KeptMap {
  RobotModel robot{};
  MapOptions options{};
  std::string options_toml{};
};

[[nodiscard]] SettledMap settle_kept_map(const std::string& out, const AppContext& context,
                                         KeptMap& kept);
/// Reads the state of a folder and closes the last loops, until the user interrupts. Throws
/// DataError as read_kept_state() does, and when the state is damaged.
[[nodiscard]] MapEditor open_kept_map(const std::string& out, const AppContext& context,
                                      KeptMap& kept);

}  // namespace loopstone::app
