#pragma once

#include <string>
#include <vector>

#include "loopstone/base/memory_budget.hpp"
#include "loopstone/formats/edits_file.hpp"
#include "loopstone/formats/left_out.hpp"
#include "loopstone/slam/map_verdict.hpp"

namespace loopstone {

/// What is to be said where a map is edited that has a floor in colour.
inline constexpr const char* kColourIsLost =
    "the floor of the map that was edited is coloured; this one is not: that needs the log";

/// What the summary.json of a folder of results still knows of the log, for an edit of its map.
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
[[nodiscard]] EditedFolder read_edited_folder(const std::string& folder,
                                              const MemoryBudget& budget = {});

}  // namespace loopstone
