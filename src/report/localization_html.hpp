#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "loopstone/report/localization_outputs.hpp"
#include "report/output_files.hpp"

namespace loopstone {

/// report.html of a localisation: one page that needs nothing else, no network, no script.
[[nodiscard]] std::string format_localization_report(const LocalizationResult& result,
                                                     const Grid<std::int8_t>& occupancy,
                                                     const LocalizationRunInfo& info,
                                                     std::string_view map_png,
                                                     const std::vector<ListedFile>& files);

}  // namespace loopstone
