#pragma once

#include <string>
#include <vector>

#include "app.hpp"
#include "loopstone/formats/edits_file.hpp"
#include "loopstone/formats/left_out.hpp"
#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/slam/map_editor.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/map_verdict.hpp"
#include "loopstone/slam/settled_map.hpp"

// A folder of results as something that can be edited: its state, and what its summary.json still
// knows of the log.

namespace loopstone::app {

struct EditedFolder {
  std::string log{};
  LeftOut left_out{};
  std::vector<std::string> log_warnings{};
  Verdict verdict = Verdict::kUnknown;
  bool has_texture = false;
  EditsFile edits{};  ///< that were done to it already
  bool was_edited = false;
};

/// Of a folder with a state and no summary.json, as a run leaves it that was killed, nothing is
/// known. Throws DataError when there is no summary.json of a whole run, or one of the edits that
/// it tells of is not there any more.
[[nodiscard]] EditedFolder read_edited_folder(const std::string& out);

/// What the map was made by.
struct KeptMap {
  RobotModel robot{};
  MapOptions options{};
  std::string options_toml{};
};

[[nodiscard]] SettledMap settle_kept_map(const std::string& out, const AppContext& context,
                                         KeptMap& kept);
/// Reads the state of a folder and closes the last loops, until the user interrupts. Throws
/// DataError as read_kept_session() does, and when the state is damaged.
[[nodiscard]] MapEditor open_kept_map(const std::string& out, const AppContext& context,
                                      KeptMap& kept);

}  // namespace loopstone::app
