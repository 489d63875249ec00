#pragma once

#include <string>
#include <vector>

#include "loopstone/formats/g2o.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/graph/optimize_graph.hpp"
#include "loopstone/report/run_info.hpp"

namespace loopstone {

/// A pose graph of a file and its solution, as reports show them.
struct GraphRun {
  std::string name;             ///< of the file, without folders
  GraphFile file{};             ///< with the poses and landmarks of the solution
  std::vector<Pose2> before{};  ///< what the picture shows beside the solution
  std::string before_name;      ///< "file" or "odometry"
  double before_cost = 0.0;     ///< sum of e^T information e there
  GraphOptimisation found{};
  double read_s = 0.0;  ///< wall time of reading
};

/// \param file   as it was read: its own poses, or odometry when it has none, are what the solution
///               is shown beside
/// \param found  the solution of its graph; its poses and landmarks are put into the file
[[nodiscard]] GraphRun make_graph_run(std::string name, GraphFile file, GraphOptimisation found);

/// "intel.g2o: 1,728 poses, 2,512 edges: cost 53.9 -> 45.0047 in 7 steps, 8.2 ms; certified ..."
[[nodiscard]] std::string graph_summary_line(const GraphRun& run);

/// What was proven and of which objective, as a sentence.
[[nodiscard]] std::string certificate_sentence(const GraphRun& run);

/// Before and after, with what they cost above them.
[[nodiscard]] Image draw_graph_run(const GraphRun& run, int panel_px = 1000);

/// One self-contained HTML page: the picture, all figures with units, what was certified, the edges
/// that fit worst and those that were set aside. `info` says who made it from what.
[[nodiscard]] std::string format_graph_report(const GraphRun& run, const RunInfo& info);

/// `edge,kind,from,to,chi2,weight`, one line an edge, ids as in the file.
[[nodiscard]] std::string format_edge_weights(const GraphRun& run);

}  // namespace loopstone
