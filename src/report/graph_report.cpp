#include "loopstone/report/graph_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <string_view>
#include <utility>

#include "loopstone/report/graph_picture.hpp"
#include "report/html_parts.hpp"
#include "report/text.hpp"

namespace loopstone {

namespace {

constexpr std::size_t kMostRows = 20;
constexpr std::size_t kMostSetAside = 200;

const Pose2& pose_of(const GraphRun& run, NodeId node) {
  return run.file.graph.poses[static_cast<std::size_t>(node.index)];
}

std::int64_t id_of(const GraphRun& run, NodeId node) {
  return run.file.ids[static_cast<std::size_t>(node.index)];
}

double weight_of(const GraphRun& run, std::size_t edge) {
  const std::vector<double>& weights = run.found.solved.edge_weights;
  return edge < weights.size() ? weights[edge] : 1.0;
}

double chi2_of(const GraphRun& run, std::size_t edge) {
  const RelativePoseEdge& e = run.file.graph.edges[edge];
  return edge_chi2(e, pose_of(run, e.from), pose_of(run, e.to));
}

std::string cost_text(double cost) {
  return cost < 1e6 ? fmt::format("{:.9g}", cost) : fmt::format("{:.3g}", cost);
}

std::string milliseconds(double seconds) { return fmt::format("{:.2f} ms", 1e3 * seconds); }

std::string edge_table(const GraphRun& run, const std::vector<std::size_t>& edges) {
  std::string html =
      "<div class=\"scroll\"><table class=\"list\"><thead><tr><th>from</th><th>to</th>"
      "<th>kind</th><th class=\"n\">chi2</th><th class=\"n\">weight</th>"
      "<th class=\"n\">off by [m]</th><th class=\"n\">[deg]</th></tr></thead><tbody>\n";
  for (const std::size_t i : edges) {
    const RelativePoseEdge& edge = run.file.graph.edges[i];
    const Eigen::Vector3d error = edge_error(edge, pose_of(run, edge.from), pose_of(run, edge.to));
    html += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{:.3f}</td>"
        "<td class=\"n\">{:.3f}</td><td class=\"n\">{:.2f}</td></tr>\n",
        id_of(run, edge.from), id_of(run, edge.to), to_string(edge.kind), readable(chi2_of(run, i)),
        weight_of(run, i), error.head<2>().norm(), degrees(std::abs(error.z())));
  }
  return html + "</tbody></table></div>\n";
}

/// Edge numbers by falling chi2.
std::vector<std::size_t> by_chi2(const GraphRun& run, bool those_set_aside, std::size_t most) {
  std::vector<std::size_t> edges;
  for (std::size_t i = 0; i < run.file.graph.edges.size(); ++i) {
    if ((weight_of(run, i) < kSetAsideBelow) == those_set_aside) edges.push_back(i);
  }
  std::vector<double> chi2(run.file.graph.edges.size());
  for (const std::size_t i : edges) chi2[i] = chi2_of(run, i);
  std::stable_sort(edges.begin(), edges.end(),
                   [&](std::size_t a, std::size_t b) { return chi2[a] > chi2[b]; });
  if (edges.size() > most) edges.resize(most);
  return edges;
}

std::int64_t closures_of(const PoseGraph& graph) {
  return std::ranges::count(graph.edges, EdgeKind::kLoopClosure, &RelativePoseEdge::kind);
}

/// Of what is proven: nobody shall take it for a proof of the whole graph.
std::string proven_words(const Certificate& c) {
  if (c.is_of_whole_graph()) return "certified";
  return count_of(static_cast<std::int64_t>(c.edges), "edge", "edges") +
         " that were kept certified";
}

std::string words_on_set_aside(const GraphRun& run) {
  const Certificate& c = run.found.certified->certificate;
  if (c.is_of_whole_graph()) return "";
  return fmt::format(
      "; nothing is proven of the {} set aside ({} of {}), nor that setting them aside was right",
      count_of(static_cast<std::int64_t>(c.edges_set_aside), "edge", "edges"), c.closures_set_aside,
      count_of(closures_of(run.file.graph), "loop closure", "loop closures"));
}

std::string figures(const GraphRun& run) {
  const PoseGraph& graph = run.file.graph;
  const std::int64_t closures = closures_of(graph);
  const auto count = [](auto n) { return with_thousands(static_cast<std::int64_t>(n)); };
  std::string html = "<div class=\"figures\">\n";
  html +=
      html_key_table("Graph", {{"poses", count(graph.poses.size())},
                               {"edges", count(graph.edges.size())},
                               {"of them loop closures", count(closures)},
                               {"repeated between the same poses", count(run.file.duplicate_edges)},
                               {"from a later pose to an earlier", count(run.file.backward_edges)},
                               {"landmarks", count(graph.landmarks.size())},
                               {"priors", count(graph.priors.size())}});
  html += html_key_table("Solution",
                         {{"status", std::string(to_string(run.found.solved.status))},
                          {"start", std::string(to_string(run.found.start.initialisation))},
                          {"cost at the start", cost_text(run.found.start.cost)},
                          {"cost, sum of e<sup>T</sup>&Omega;e", cost_text(run.found.solved.cost)},
                          {"after the robust kernel", cost_text(run.found.solved.robust_cost)},
                          {"edges set aside", count(edges_set_aside(run.found.solved))},
                          {"steps", count(run.found.iterations())}});
  html += html_key_table("Time",
                         {{"reading", milliseconds(run.read_s)},
                          {"start", milliseconds(run.found.times.start_s)},
                          {"certified minimum and proof", milliseconds(run.found.times.certify_s)},
                          {"solution", milliseconds(run.found.times.solve_s)}});
  if (run.found.certified) {
    const Certificate& c = run.found.certified->certificate;
    html += html_key_table(
        "Certificate", {{"status", std::string(to_string(c.status))},
                        {"of edges", count(c.edges)},
                        {"not of edges, set aside", count(c.edges_set_aside)},
                        {"of them loop closures", count(c.closures_set_aside)},
                        {"isotropic cost", cost_text(c.cost)},
                        {"proven lower bound", cost_text(c.lower_bound)},
                        {"gap at most", fmt::format("{:.3g}", c.optimality_gap)},
                        {"smallest eigenvalue", fmt::format("{:.3g}", c.min_eigenvalue)},
                        {"proven to be above", fmt::format("{:.3g}", -c.eigenvalue_tolerance)},
                        {"local minima left behind", count(run.found.certified->escapes)},
                        {"rank of the relaxation climbed to", count(run.found.certified->rank)}});
  }
  return html + "</div>\n";
}

}  // namespace

GraphRun make_graph_run(std::string name, GraphFile file, GraphOptimisation found) {
  GraphRun run;
  run.name = std::move(name);
  // What a user would look at without a solution.
  GraphStart before = make_start(
      file.graph, file.has_poses ? Initialisation::kAsGiven : Initialisation::kOdometryChain);
  run.before = std::move(before.poses);
  run.before_name = to_string(before.initialisation);
  run.before_cost = before.cost;
  run.file = std::move(file);
  run.file.graph.poses = found.solved.poses;
  run.file.graph.landmarks = found.solved.landmarks;
  run.found = std::move(found);
  return run;
}

std::string certificate_sentence(const GraphRun& run) {
  if (!run.found.certified) return "not certified: nothing was asked to be proven";
  const Certificate& c = run.found.certified->certificate;
  const std::string of = c.is_of_whole_graph()
                             ? std::string()
                             : fmt::format(" of the {} edges that were kept", c.edges);
  switch (c.status) {
    case CertificateStatus::kCertified:
      return fmt::format(
          "certified{}: the isotropic optimum{}, {}, is global to within {:.2g}; the solution is "
          "the "
          "minimum of chi2 next to it{}",
          c.is_of_whole_graph() ? "" : " in part", of, cost_text(c.cost), c.optimality_gap,
          words_on_set_aside(run));
    case CertificateStatus::kGapOpen:
      return fmt::format(
          "NOT certified: the isotropic cost{} is {}, and no solution is below {}; the relaxation "
          "is "
          "not tight",
          of, cost_text(c.cost), cost_text(c.lower_bound));
    case CertificateStatus::kNotOptimal:
      return fmt::format(
          "NOT certified: a better solution of the isotropic problem{} exists (smallest eigenvalue "
          "{:.3g})",
          of, c.min_eigenvalue);
    case CertificateStatus::kNotConverged:
      return "NOT certified: the iterations ran out";
    case CertificateStatus::kNumericalFailure:
      return "NOT certified: a factorisation failed";
    case CertificateStatus::kUnsupported:
      return "NOT certified: more than one pose is held, so that the problem is another one";
  }
  return "NOT certified";
}

std::string graph_summary_line(const GraphRun& run) {
  std::string line = fmt::format(
      "{}: {}, {}: cost {} -> {} in {}, {}", run.name,
      count_of(static_cast<std::int64_t>(run.file.graph.poses.size()), "pose", "poses"),
      count_of(static_cast<std::int64_t>(run.file.graph.edges.size()), "edge", "edges"),
      cost_text(run.found.start.cost), cost_text(run.found.solved.cost),
      count_of(run.found.iterations(), "step", "steps"), milliseconds(run.found.times.wall_s()));
  if (run.found.solved.status != SolveStatus::kConverged) {
    line += "; " + std::string(to_string(run.found.solved.status));
  }
  if (const std::size_t aside = edges_set_aside(run.found.solved); aside > 0) {
    line += "; " + count_of(static_cast<std::int64_t>(aside), "edge", "edges") + " set aside";
  }
  if (run.found.certified) {
    const Certificate& c = run.found.certified->certificate;
    line += c.certified() ? fmt::format("; {} to {:.2g}", proven_words(c), c.optimality_gap)
                          : "; NOT certified: " + std::string(to_string(c.status));
  }
  return line;
}

Image draw_graph_run(const GraphRun& run, int panel_px) {
  GraphScene scene;
  scene.graph = &run.file.graph;
  scene.before = run.before;
  scene.weights = run.found.solved.edge_weights;
  scene.before_title =
      fmt::format("before: {}, cost {}", run.before_name, cost_text(run.before_cost));
  const bool proven = run.found.certified && run.found.certified->certificate.certified();
  scene.after_title =
      fmt::format("after: cost {}{}", cost_text(run.found.solved.cost),
                  proven ? ", " + proven_words(run.found.certified->certificate) : "");
  return draw_graph_picture(scene, {.panel_px = panel_px, .set_aside_below = kSetAsideBelow});
}

std::string format_graph_report(const GraphRun& run, const RunInfo& info) {
  const bool proven = run.found.certified && run.found.certified->certificate.certified();
  const std::size_t aside = edges_set_aside(run.found.solved);
  std::string body = "<p class=\"verdict\">" + escape_html(graph_summary_line(run)) + "</p>\n";
  if (run.found.certified) {
    const bool whole = run.found.certified->certificate.is_of_whole_graph();
    body += fmt::format("<p class=\"{}\">{}</p>\n", !proven ? "bad" : (whole ? "good" : ""),
                        escape_html(certificate_sentence(run)));
  }
  for (const std::string& note : run.file.notes) {
    body += "<p class=\"soft\">" + escape_html(note) + "</p>\n";
  }
  for (const auto& [tag, count] : run.file.skipped_tags) {
    body += fmt::format("<p class=\"soft\">{} skipped: {}</p>\n", count_of(count, "line", "lines"),
                        escape_html(tag));
  }
  body += html_figure(
      html_picture(encode_png(draw_graph_run(run, 700)), "map", "the pose graph before and after"),
      "Before and after. The path runs from blue to amber; closures that fit are "
      "grey, strained ones dark, those set aside red.");
  body += figures(run);
  if (aside > 0) {
    body +=
        fmt::format("<h2>Set aside</h2>\n<p>{} with a weight below {}{}</p>\n",
                    count_of(static_cast<std::int64_t>(aside), "edge", "edges"), kSetAsideBelow,
                    aside > kMostSetAside ? fmt::format("; the {} worst:", kMostSetAside) : ":");
    body += edge_table(run, by_chi2(run, true, kMostSetAside));
  }
  body += "<h2>Edges that fit worst</h2>\n" + edge_table(run, by_chi2(run, false, kMostRows));
  if (!info.options_toml.empty()) body += html_options(info);
  return html_page("Pose graph " + run.name, body, info);
}

std::string format_edge_weights(const GraphRun& run) {
  std::string text = "edge,kind,from,to,chi2,weight\n";
  for (std::size_t i = 0; i < run.file.graph.edges.size(); ++i) {
    const RelativePoseEdge& edge = run.file.graph.edges[i];
    fmt::format_to(std::back_inserter(text), "{},{},{},{},{:.9g},{:.9g}\n", i, to_string(edge.kind),
                   id_of(run, edge.from), id_of(run, edge.to), chi2_of(run, i), weight_of(run, i));
  }
  return text;
}

}  // namespace loopstone
