#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/slam/map_edit.hpp"

namespace loopstone {

/// Reads the edits of a map from TOML, as docs/editing.md describes it: [[edit]] tables, done in
/// their order. Each has the line it begins at.
/// \param path  names the text in the problems
/// Throws OptionsError with all problems at once.
[[nodiscard]] std::vector<MapEdit> parse_edits(std::string_view toml, const std::string& path);

/// Edits and the text that they were read from.
struct EditsFile {
  std::string text{};
  std::vector<MapEdit> edits{};
};

/// The same from a file. Throws DataError when it can't be read.
[[nodiscard]] EditsFile read_edits_file(const std::string& path);

/// More edits of a map that was edited: between both stands a MapAsEdited.
[[nodiscard]] EditsFile joined(EditsFile before, const EditsFile& more);

/// The edits as TOML. Read back they are the same.
[[nodiscard]] std::string edits_to_toml(std::span<const MapEdit> edits);

}  // namespace loopstone
