#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "loopstone/report/map_outputs.hpp"

namespace loopstone {

/// A file that stands beside the report.
struct ListedFile {
  std::string name;
  std::string content;  ///< in words
  std::int64_t bytes = 0;
};

/// report.html: one page that needs nothing else, no network, no script.
[[nodiscard]] std::string format_report(const MapResult& result, const RunInfo& info,
                                        std::string_view map_png,
                                        const std::vector<ListedFile>& files);

}  // namespace loopstone
