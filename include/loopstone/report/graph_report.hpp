#pragma once

#include <optional>
#include <string>
#include <vector>

#include "loopstone/formats/g2o.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/graph/certificate.hpp"
#include "loopstone/graph/initial_poses.hpp"
#include "loopstone/graph/solver.hpp"
#include "loopstone/report/run_info.hpp"

namespace loopstone {

/// Everything about one solution of a pose graph.
struct GraphRun {
  std::string name;             ///< of the file, without folders
  GraphFile file{};             ///< with the poses and landmarks of the solution
  std::vector<Pose2> before{};  ///< what the picture shows beside the solution
  std::string before_name;      ///< "file" or "odometry"
  double before_cost = 0.0;     ///< sum of e^T information e there
  Initialisation start = Initialisation::kChordal;  ///< where the solution began
  double start_cost = 0.0;
  SolveResult solve{};
  std::optional<CertifiedSolution> certified{};
  std::size_t certified_edges = 0;  ///< of all; fewer when robust weights set some aside
  double read_s = 0.0;              ///< wall time of each part
  double start_s = 0.0;
  double certify_s = 0.0;
  double solve_s = 0.0;
  double cpu_s = 0.0;  ///< CPU time of start, certified minimum and solution together

  /// Without reading and writing.
  [[nodiscard]] double optimisation_s() const { return start_s + certify_s + solve_s; }
};

/// Edges of less weight count as set aside.
inline constexpr double kSetAsideBelow = 0.5;
[[nodiscard]] std::size_t edges_set_aside(const GraphRun& run);

/// "intel.g2o: 1,728 poses, 2,512 edges: cost 53.9 -> 45.0047 in 7 steps, 8.2 ms; certified ..."
[[nodiscard]] std::string graph_summary_line(const GraphRun& run);

/// What was proven and of which objective, as a sentence.
[[nodiscard]] std::string certificate_sentence(const GraphRun& run);

/// Before and after, with what they cost above them.
[[nodiscard]] Image draw_graph_run(const GraphRun& run, int panel_px = 1000);

/// One self-contained HTML page: the picture, all figures with units, what was certified, the edges that fit worst and those
/// that were set aside. `info` says who made it from what.
[[nodiscard]] std::string format_graph_report(const GraphRun& run, const RunInfo& info);

/// `edge,kind,from,to,chi2,weight`, one line an edge, ids as in the file.
[[nodiscard]] std::string format_edge_weights(const GraphRun& run);

}  // namespace loopstone
