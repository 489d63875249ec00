#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "loopstone/report/run_info.hpp"
#include "loopstone/slam/map_result.hpp"
#include "report/output_files.hpp"

namespace loopstone {

/// report.html: one page that needs nothing else, no network, no script.
/// \param quality_html  the section on how good the map is; may be empty
/// \param floor_html    the section on the colour of the floor; may be empty
[[nodiscard]] std::string format_report(const MapResult& result, const RunInfo& info,
                                        std::string_view map_png,
                                        const std::vector<ListedFile>& files,
                                        const std::string& quality_html = {},
                                        const std::string& floor_html = {});

}  // namespace loopstone
