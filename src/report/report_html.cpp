#include "report/report_html.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "report/calibration_summary.hpp"
#include "report/html_parts.hpp"
#include "report/motion_profile.hpp"
#include "report/summary.hpp"
#include "report/svg_plot.hpp"
#include "report/text.hpp"

namespace loopstone {
namespace {

constexpr int kPlotSpans = 800;
constexpr std::size_t kMostClosureRows = 250;

std::string verdict(const MapResult& result, const RunInfo& info) {
  const MapStatistics& s = result.statistics;
  std::string text;
  if (!result.complete)
    text +=
        "<strong class=\"bad\">Incomplete: the run was stopped before the end of the "
        "log.</strong> ";
  text +=
      fmt::format("{} m² mapped from {} along {} m", readable(figures_of(result.map).known_area_m2),
                  count_of(s.scans, "scan", "scans"), readable(s.path_length_m));
  text += s.loop_closures_accepted == 0
              ? "; no loop was closed"
              : "; " + count_of(s.loop_closures_accepted, "loop closure", "loop closures") +
                    " accepted";
  const double factor = ratio_or_zero(s.duration_s, info.wall_time_s);
  if (factor > 0.0) {
    text += fmt::format("; {} of recording in {} ({} times real time)", readable_time(s.duration_s),
                        readable_time(info.wall_time_s), readable(factor));
  }
  return text + ".";
}

std::string key_figures(const MapResult& result, const RunInfo& info) {
  const MapStatistics& s = result.statistics;
  const MapFigures map = figures_of(result.map);
  std::string html = "<div class=\"figures\">\n";
  html += html_key_table(
      "Map", {{"known area", readable(map.known_area_m2) + " m²"},
              {"free area", readable(map.free_area_m2) + " m²"},
              {"extent", readable(map.width_m) + " × " + readable(map.height_m) + " m"},
              {"cell", readable(100.0 * result.map.log_odds.frame().resolution) + " cm"},
              {"submaps", with_thousands(s.submaps)}});
  html += html_key_table(
      "Recording", {{"duration", readable_time(s.duration_s)},
                    {"path", readable(s.path_length_m) + " m"},
                    {"scans used", with_thousands(s.scans)},
                    {"scans dropped", with_thousands(s.scans_dropped)},
                    {"records skipped", with_thousands(info.left_out.skipped.records)},
                    {"path with a direction unseen", readable(s.degenerate_travel_m) + " m"}});
  html += html_key_table(
      "Pose graph",
      {{"key scans", with_thousands(s.key_scans)},
       {"poses", with_thousands(static_cast<std::int64_t>(result.graph.poses.size()))},
       {"edges", with_thousands(static_cast<std::int64_t>(result.graph.edges.size()))},
       {"loop closures accepted", with_thousands(s.loop_closures_accepted)},
       {"loop closures rejected", with_thousands(s.loop_closures_rejected)},
       {"cost Σ eᵀΩe", readable(s.graph_cost)},
       {"points about walls, before", readable(1e3 * s.surface_spread_before_m) + " mm"},
       {"points about walls, adjusted", readable(1e3 * s.surface_spread_m) + " mm"}});
  html += html_key_table(
      "Computation",
      {{"wall time", readable_time(info.wall_time_s)},
       {"CPU time, all threads", readable_time(info.cpu_time_s)},
       {"front end, wall", readable_time(s.front_end_s)},
       {"loop closing, wall", readable_time(s.loop_closing_s)},
       {"optimisation, wall", readable_time(s.optimisation_s)},
       {"adjustment to surfaces, wall", readable_time(s.adjustment_s)},
       {"drawing the map, wall", readable_time(s.rendering_s)},
       {"judging the map, wall", readable_time(s.judging_s)},
       {"speed",
        readable(ratio_or_zero(static_cast<double>(s.scans), info.wall_time_s)) + " scans/s"},
       {"peak memory", readable_bytes(info.peak_memory_bytes)},
       {"wide searches", with_thousands(s.searches)}});
  return html + "</div>\n";
}

PlotCurve path_curve(const Trajectory& trajectory, const Pose2& target_T_source, std::string label,
                     std::string css_class) {
  PlotCurve curve{std::move(label), std::move(css_class)};
  for (const StampedPose2& stamped : trajectory.poses()) {
    const Eigen::Vector2d point = target_T_source * stamped.pose.translation();
    curve.x.push_back(point.x());
    curve.y.push_back(point.y());
  }
  return curve;
}

std::string motion_plots(const MapResult& result) {
  MotionProfile profile = motion_profile(result.trajectory, kPlotSpans);
  PlotSpec speed{.x_label = "time [s]", .y_label = "speed [m/s]"};
  speed.curves.push_back({"speed", "a", profile.time_s, std::move(profile.speed_m_s)});
  PlotSpec yaw_rate{.x_label = "time [s]", .y_label = "yaw rate [rad/s]"};
  yaw_rate.curves.push_back(
      {"yaw rate", "a", std::move(profile.time_s), std::move(profile.yaw_rate_rad_s)});
  return html_figure(svg_plot(std::move(speed)), "Forward speed along the optimised path.") +
         html_figure(svg_plot(std::move(yaw_rate)), "Yaw rate, counter-clockwise positive.");
}

std::string path_plot(const MapResult& result) {
  if (result.trajectory.size() < 2) return {};
  PlotSpec spec{.x_label = "x [m]", .y_label = "y [m]", .equal_axes = true};
  if (result.odometry.size() > 1) {
    const Pose2 map_T_odom =
        result.trajectory.front().pose * result.odometry.front().pose.inverse();
    spec.curves.push_back(path_curve(result.odometry, map_T_odom, "odometry alone", "b"));
  }
  spec.curves.push_back(path_curve(result.trajectory, Pose2{}, "optimised", "a"));
  return html_figure(svg_plot(std::move(spec)),
                     "Odometry laid on the first pose of the optimised path: their distance is the "
                     "drift that mapping removed.");
}

class ClosureTable {
 public:
  explicit ClosureTable(const MapResult& result) : result_(result) {}

  [[nodiscard]] std::string rows(bool stand) const {
    std::string html;
    std::size_t shown = 0;
    std::size_t left_out = 0;
    for (const LoopClosure& closure : result_.loop_closures) {
      if (closure.stands() != stand) continue;
      if (shown == kMostClosureRows) {
        ++left_out;
        continue;
      }
      ++shown;
      html += row(closure);
    }
    if (shown == 0) return {};
    if (left_out > 0) {
      html += "<tr><td colspan=\"8\">and " + with_thousands(static_cast<std::int64_t>(left_out)) +
              " more</td></tr>\n";
    }
    return std::string(
               "<div class=\"scroll\"><table class=\"list\"><thead><tr><th "
               "class=\"n\">from</th><th class=\"n\">to</th>"
               "<th class=\"n\">score</th><th class=\"n\">second</th><th "
               "class=\"n\">overlap</th><th class=\"n\">agreement</th>"
               "<th class=\"n\">χ²</th><th>") +
           (stand ? "" : "reason") + "</th></tr></thead><tbody>\n" + html +
           "</tbody></table></div>\n";
  }

 private:
  [[nodiscard]] std::string when(NodeId node) const {
    const auto index = static_cast<std::size_t>(node.index);
    if (node.index < 0 || index >= result_.node_stamps.size() || result_.trajectory.empty()) {
      return fmt::format("node {}", node.index);
    }
    return fmt::format("{:.1f} s",
                       (result_.node_stamps[index] - result_.trajectory.front().stamp).seconds());
  }

  [[nodiscard]] std::string row(const LoopClosure& closure) const {
    return fmt::format(
        "<tr><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{:.2f}</td><td "
        "class=\"n\">{}</td>"
        "<td class=\"n\">{:.2f}</td><td class=\"n\">{:.2f}</td><td "
        "class=\"n\">{}</td><td>{}</td></tr>\n",
        when(closure.from), when(closure.to), closure.score,
        closure.second_score ? fmt::format("{:.2f}", *closure.second_score) : "", closure.overlap,
        closure.agreement, closure.chi2 ? readable(*closure.chi2) : "",
        closure.stands() ? "<span class=\"good\">accepted</span>"
                         : escape_html(std::string(to_string(closure.reason))));
  }

  const MapResult& result_;
};

std::string loop_closures(const MapResult& result) {
  std::string html = "<h2>Loop closures</h2>\n";
  if (result.loop_closures.empty())
    return html + "<p>No place was recognised, and none looked like one seen before.</p>\n";
  html +=
      "<p class=\"soft\">Times count from the first scan. Score: share of the scan's points that "
      "the older submap explains; second: the "
      "best score elsewhere in the search window (near the score means ambiguous); overlap: share "
      "of the points that fall where "
      "the submap was observed; agreement: share of those on a surface that faces the same way, or "
      "of each submap's surfaces that "
      "the other one could see, share that it saw; "
      "χ²: disagreement with the final map.</p>\n";
  const ClosureTable table(result);
  html += table.rows(true);
  if (const std::string rejected = table.rows(false); !rejected.empty()) {
    const auto count = std::count_if(result.loop_closures.begin(), result.loop_closures.end(),
                                     [](const LoopClosure& closure) { return !closure.stands(); });
    html += "<details><summary>" + count_of(count, "rejected candidate", "rejected candidates") +
            "</summary>\n" + rejected + "</details>\n";
  }
  return html;
}

}  // namespace

std::string format_report(const MapResult& result, const RunInfo& info, std::string_view map_png,
                          const std::vector<ListedFile>& files, const std::string& quality_html,
                          const std::string& floor_html) {
  std::string body = "<p class=\"verdict\">" + verdict(result, info) + "</p>\n";
  body += html_warnings(result.warnings);
  body += html_figure(html_picture(map_png, "map", "Occupancy map with the robot's path"),
                      "White is free, black occupied, grey not seen. The path runs from blue "
                      "(start) to orange (end); "
                      "accepted loop closures are green.");
  body += quality_html;
  body += "<h2>Key figures</h2>\n" + key_figures(result, info);
  body += calibration_html(result.calibration);
  body += floor_html;
  body += "<h2>Path</h2>\n" + path_plot(result) + motion_plots(result);
  body += loop_closures(result);
  body += html_options(info) + html_file_list(files);
  return html_page("Map of " + log_name(info), body, info);
}

}  // namespace loopstone
