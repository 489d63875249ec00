#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "loopstone/grid/grid_frame.hpp"
#include "loopstone/report/edit_outputs.hpp"
#include "report/output_files.hpp"

namespace loopstone {

[[nodiscard]] nlohmann::ordered_json edits_json(const EditOutputs& edits);
[[nodiscard]] std::string html_edits(const EditOutputs& edits);

/// edits.toml, and where there are zones their masks and how nav2 is to read them.
/// \param frame  of the map
void add_edit_files(const EditOutputs& edits, const GridFrame& frame, FileSet& files);

}  // namespace loopstone
