#pragma once

#include <string>
#include <vector>

#include "loopstone/mapping/filter_mask.hpp"
#include "loopstone/slam/map_editor.hpp"

namespace loopstone {

/// An edit as a report tells it.
struct ToldEdit {
  std::string kind{};
  EditReport report{};
};

/// What the edits of a map leave beside its results.
struct EditOutputs {
  std::string edits_toml{};       ///< all of them, from the map that was kept on
  std::vector<ToldEdit> edits{};  ///< in order
  std::string edited{};           ///< the folder whose map they were done to
  Pose2 new_T_map{};              ///< where the frame of the first map lies in this one's
  MapShift shift{};
  std::int64_t cells_erased = 0;
  std::vector<KeepOutZone> keep_out{};
  std::vector<SpeedZone> speed{};
  Verdict verdict_before = Verdict::kUnknown;  ///< of the whole map
  double open_s = 0.0;  ///< to read the state, close the last loops and place the key scans
  double edit_s = 0.0;  ///< of all edits
  double draw_s = 0.0;  ///< to adjust, draw and judge the map
};

/// The object "edits" of summary.json, and of `loopstone edit --check --json`.
[[nodiscard]] std::string format_edits(const EditOutputs& edits);

}  // namespace loopstone
