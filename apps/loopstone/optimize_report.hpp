#pragma once

#include "loopstone/report/graph_report.hpp"
#include "optimize_request.hpp"
#include "result.hpp"

namespace loopstone::app {

/// The table and the JSON object of a solved pose graph.
[[nodiscard]] Result report_graph_run(const GraphRun& run, const OptimizeRequest& request);

}  // namespace loopstone::app
