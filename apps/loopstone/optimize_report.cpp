#include "optimize_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace loopstone::app {

namespace {

using Json = nlohmann::ordered_json;

void add_file(Result& result, const GraphRun& run) {
  const PoseGraph& graph = run.file.graph;
  const auto closures = std::count_if(
      graph.edges.begin(), graph.edges.end(),
      [](const RelativePoseEdge& edge) { return edge.kind == EdgeKind::kLoopClosure; });
  Json skipped = Json::object();
  for (const auto& [tag, count] : run.file.skipped_tags) skipped[tag] = count;
  result.add_json("graph", run.name)
      .add_json("poses", graph.poses.size())
      .add_json("edges", graph.edges.size())
      .add_json("loop_closures", closures)
      .add_json("landmarks", graph.landmarks.size())
      .add_json("landmark_edges", graph.landmark_edges.size())
      .add_json("priors", graph.priors.size())
      .add_json("fixed", graph.fixed.size())
      .add_json("duplicate_edges", run.file.duplicate_edges)
      .add_json("backward_edges", run.file.backward_edges)
      .add_json("skipped_lines", std::move(skipped))
      .add_json("notes", run.file.notes);
  std::string text = fmt::format("{} poses, {} edges, {} of them loop closures", graph.poses.size(),
                                 graph.edges.size(), closures);
  if (!graph.landmarks.empty()) text += fmt::format(", {} landmarks", graph.landmarks.size());
  if (!graph.priors.empty()) text += fmt::format(", {} priors", graph.priors.size());
  if (run.file.duplicate_edges > 0) {
    text += fmt::format(", {} edges repeat others", run.file.duplicate_edges);
  }
  result.add_row("graph", text);
}

void add_certificate(Result& result, const GraphRun& run) {
  const GraphOptimisation& found = run.found;
  if (!found.certified) {
    result.add_json("certified", false)
        .add_json("min_eigenvalue", nullptr)
        .add_json("optimality_gap", nullptr)
        .add_json("certificate", {{"status", "not_asked"}});
    return;
  }
  const CertifiedSolution& solution = *found.certified;
  const Certificate& certificate = solution.certificate;
  result.add_json("certified", certificate.certified())
      .add_json("min_eigenvalue", certificate.min_eigenvalue)
      .add_json("optimality_gap", certificate.optimality_gap)
      .add_json("certificate.status", to_string(certificate.status))
      .add_json("certificate.what", certificate_sentence(run))
      .add_json("certificate.objective",
                "sum of kappa |R_to - R_from R|_F^2 + tau |t_to - t_from - R_from t|^2, "
                "kappa = I33, tau = 2 / tr(I_tt^-1)")
      .add_json("certificate.edges", certificate.edges)
      .add_json("certificate.edges_set_aside", certificate.edges_set_aside)
      .add_json("certificate.loop_closures_set_aside", certificate.closures_set_aside)
      .add_json("certificate.whole_graph", certificate.is_of_whole_graph())
      .add_json("certificate.cost", certificate.cost)
      .add_json("certificate.lower_bound", certificate.lower_bound)
      .add_json("certificate.eigenvalue_tolerance", certificate.eigenvalue_tolerance)
      .add_json("certificate.iterations", solution.iterations)
      .add_json("certificate.escapes", solution.escapes)
      .add_json("certificate.rank", solution.rank)
      .add_row("certificate", certificate_sentence(run))
      .add_row("min. eigenvalue",
               fmt::format("{:.3g}, proven to be above {:.3g}", certificate.min_eigenvalue,
                           -certificate.eigenvalue_tolerance));
  if (solution.escapes > 0) {
    result.add_row("escapes",
                   fmt::format("{} local {} left behind, over rank {}", solution.escapes,
                               solution.escapes == 1 ? "minimum" : "minima", solution.rank));
  }
}

}  // namespace

Result report_graph_run(const GraphRun& run, const OptimizeRequest& request) {
  const GraphOptimisation& found = run.found;
  const std::size_t aside = edges_set_aside(found.solved);
  const int iterations = found.iterations();
  Result result;
  result.add_row("", graph_summary_line(run));
  add_file(result, run);
  result.add_json("initial", to_string(found.start.initialisation))
      .add_json("cost_file", run.file.has_poses ? Json(run.before_cost) : Json(nullptr))
      .add_json("cost_initial", found.start.cost)
      .add_json("cost", found.solved.cost)
      .add_json("status", to_string(found.solved.status))
      .add_json("iterations", iterations)
      .add_json("method", to_string(request.settings.solver.method))
      .add_json("robust", request.robust())
      .add_json("robust_cost", found.solved.robust_cost)
      .add_json("edges_set_aside", aside)
      .add_row("start", fmt::format("{}{}, cost {:.9g}", to_string(found.start.initialisation),
                                    !request.initial && !request.gnc ? " (the cheapest)" : "",
                                    found.start.cost))
      .add_row("cost", fmt::format("{:.9g}", found.solved.cost), "sum of e^T Omega e")
      .add_row("status", std::string(to_string(found.solved.status)))
      .add_row("steps", fmt::format("{}", iterations));
  if (request.robust() != "none") {
    result.add_row("robust", fmt::format("{}: cost {:.9g}, {} edges set aside", request.robust(),
                                         found.solved.robust_cost, aside));
  }
  add_certificate(result, run);
  result.add_json("wall_time_s", found.times.wall_s())
      .add_json("cpu_time_s", found.times.cpu_s)
      .add_json("read_s", run.read_s)
      .add_json("start_s", found.times.start_s)
      .add_json("certify_s", found.times.certify_s)
      .add_json("solve_s", found.times.solve_s)
      .add_row("time",
               fmt::format("{:.2f} = start {:.2f} + certified minimum {:.2f} + solution {:.2f}",
                           1e3 * found.times.wall_s(), 1e3 * found.times.start_s,
                           1e3 * found.times.certify_s, 1e3 * found.times.solve_s),
               "ms");
  return result;
}

}  // namespace loopstone::app
