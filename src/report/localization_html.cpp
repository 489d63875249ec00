#include "report/localization_html.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/report/localization_picture.hpp"
#include "report/html_parts.hpp"
#include "report/localization_figures.hpp"
#include "report/localization_plots.hpp"
#include "report/state_style.hpp"
#include "report/summary.hpp"
#include "report/text.hpp"

namespace loopstone {
namespace {

constexpr std::size_t kMostRows = 250;
constexpr std::size_t kMostMoments = 12;

std::string percent(double share) { return fmt::format("{:.1f} %", 100.0 * share); }

std::string state_chip(LocalizationState state) {
  return fmt::format("<span class=\"state {}\">{}</span>", state_css_class(state),
                     to_string(state));
}

std::string since_start(const LocalizationResult& result, Stamp stamp) {
  return fmt::format("{:.1f} s", (stamp - result.start).seconds());
}

std::string verdict(const LocalizationResult& result, const LocalizationFigures& figures,
                    const LocalizationRunInfo& info) {
  std::string text;
  if (!result.complete)
    text +=
        "<strong class=\"bad\">Incomplete: the run was stopped before the end of the "
        "log.</strong> ";
  text += fmt::format("{} {} of {} along {} m", state_chip(LocalizationState::kTracking),
                      percent(figures.tracking_share), readable_time(result.duration_s),
                      readable(result.path_length_m));
  if (!figures.first_tracking_s) {
    text += ": <strong class=\"bad\">the robot was never sure of its place</strong>";
  } else if (*figures.first_tracking_s > 0.0) {
    text += fmt::format(", for the first time after {} and {} m",
                        readable_time(*figures.first_tracking_s),
                        readable(figures.first_tracking_m.value_or(0.0)));
  } else {
    text += " from the first scan on";
  }
  if (figures.lost_share > 0.0)
    text +=
        fmt::format("; {} {}", state_chip(LocalizationState::kLost), percent(figures.lost_share));
  const double factor = ratio_or_zero(result.duration_s, info.run.wall_time_s);
  if (factor > 0.0) {
    text += fmt::format("; done in {} ({} times real time)", readable_time(info.run.wall_time_s),
                        readable(factor));
  }
  return text + ".";
}

std::string sigma_text(const LocalizationEstimate& e) {
  return fmt::format("{:.1f} cm, {:.1f} cm, {:.2f}°", 100.0 * std::sqrt(e.covariance(0, 0)),
                     100.0 * std::sqrt(e.covariance(1, 1)), degrees(std::sqrt(e.covariance(2, 2))));
}

std::string pose_text(const Pose2& pose) {
  return fmt::format("{:.3f} m, {:.3f} m, {:.1f}°", pose.x, pose.y, degrees(pose.yaw));
}

std::vector<HtmlRow> confidence_rows(const LocalizationResult& result,
                                     const LocalizationFigures& figures) {
  std::vector<HtmlRow> rows{{"TRACKING, share of the time", percent(figures.tracking_share)},
                            {"DOUBTFUL", percent(figures.doubtful_share)},
                            {"LOST", percent(figures.lost_share)}};
  const bool ever = figures.first_tracking_s.has_value();
  rows.push_back(
      {"first TRACKING after", ever ? readable_time(*figures.first_tracking_s) + ", " +
                                          readable(figures.first_tracking_m.value_or(0.0)) + " m"
                                    : "never"});
  rows.push_back({"changes of state", with_thousands(figures.state_changes)});
  rows.push_back(
      {"searches of the map", with_thousands(static_cast<std::int64_t>(result.searches.size()))});
  rows.push_back({"mean probability", percent(figures.probability_mean)});
  return rows;
}

std::vector<HtmlRow> pose_rows(const LocalizationResult& result,
                               const LocalizationFigures& figures) {
  std::vector<HtmlRow> rows;
  if (!result.estimates.empty()) {
    const LocalizationEstimate& last = result.estimates.back();
    rows.push_back({"last pose x, y, yaw", pose_text(last.map_T_robot)});
    rows.push_back({"its standard deviations", sigma_text(last)});
  }
  rows.push_back(
      {"standard deviation, rms", fmt::format("{:.1f} cm, {:.2f}°", 100.0 * figures.sigma_xy_rms_m,
                                              degrees(figures.sigma_yaw_rms_rad))});
  rows.push_back({"refined by registration",
                  percent(ratio_or_zero(static_cast<double>(figures.refined),
                                        static_cast<double>(result.estimates.size())))});
  rows.push_back({"explained, mean", percent(figures.explained_mean)});
  rows.push_back({"through walls, mean", percent(figures.violations_mean)});
  rows.push_back({"unexpected, mean", percent(figures.unexpected_mean)});
  return rows;
}

std::string start_text(const LocalizationRunInfo& info) {
  if (!info.initial) return "anywhere on the map";
  return fmt::format("{} (±{:g} m, ±{:.1f}°)", pose_text(info.initial->map_T_robot),
                     info.initial->sigma_m, degrees(info.initial->sigma_rad));
}

std::string key_figures(const LocalizationResult& result, const Grid<std::int8_t>& occupancy,
                        const LocalizationFigures& figures, const LocalizationRunInfo& info) {
  const GridFrame& frame = occupancy.frame();
  std::string html = "<div class=\"figures\">\n";
  html += html_key_table("Confidence", confidence_rows(result, figures));
  html += html_key_table("Pose", pose_rows(result, figures));
  html += html_key_table("Recording",
                         {{"duration", readable_time(result.duration_s)},
                          {"path, by odometry", readable(result.path_length_m) + " m"},
                          {"scans", with_thousands(result.scans)},
                          {"scans dropped", with_thousands(result.scans_dropped)},
                          {"records skipped", with_thousands(info.run.left_out.skipped.records)},
                          {"odometry", result.had_odometry ? "yes" : "none"}});
  html += html_key_table("Map and start",
                         {{"map", escape_html(info.map_path)},
                          {"extent", readable(frame.columns * frame.resolution) + " × " +
                                         readable(frame.rows * frame.resolution) + " m"},
                          {"free area", readable(info.map_free_area_m2) + " m²"},
                          {"cell", readable(100.0 * frame.resolution) + " cm"},
                          {"start", start_text(info)},
                          {"seed", fmt::format("{}", info.seed)}});
  html += html_key_table(
      "Computation",
      {{"wall time", readable_time(info.run.wall_time_s)},
       {"CPU time, all threads", readable_time(info.run.cpu_time_s)},
       {"searches, wall", readable_time(result.search_s)},
       {"filter, wall", readable_time(result.filter_s)},
       {"speed", readable(ratio_or_zero(static_cast<double>(result.scans), info.run.wall_time_s)) +
                     " scans/s"},
       {"peak memory", readable_bytes(info.run.peak_memory_bytes)},
       {"map made ready", readable_bytes(info.map_memory_bytes)}});
  return html + "</div>\n";
}

std::string moments(const LocalizationResult& result, const Grid<std::int8_t>& occupancy) {
  if (result.snapshots.empty()) return {};
  const BeliefPainter painter(occupancy, result.start,
                              {.width_px = 560, .close_up_m = 10.0, .whole_map = false});
  const std::size_t count = std::min(result.snapshots.size(), kMostMoments);
  std::string html =
      "<h2>The belief at some moments</h2>\n<p class=\"soft\">Green: particles, with their "
      "headings in a close-up; violet rings: places where the robot may be; orange: the scan, seen "
      "from the estimate; the arrowhead is the estimate, the ellipse its 2 σ. The whole map is "
      "shown "
      "where the belief is wide, else "
      "the surroundings.</p>\n<div class=\"gallery\">\n";
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = count == 1 ? 0 : k * (result.snapshots.size() - 1) / (count - 1);
    const BeliefSnapshot& snapshot = result.snapshots[i];
    html += html_figure(
        html_picture(encode_png(painter.draw(snapshot), 6), "moment",
                     "Belief after " + since_start(result, snapshot.stamp)),
        fmt::format("{} particles, after {:.2f} m",
                    with_thousands(static_cast<std::int64_t>(snapshot.particles.size())),
                    snapshot.estimate.travelled_m));
  }
  return html + "</div>\n";
}

/// A table with a cap on its rows; `row(i)` makes the cells of one.
template <typename RowOf>
std::string list_of(const std::string& head, std::size_t columns, std::size_t count,
                    const RowOf& row) {
  std::string html =
      "<div class=\"scroll\"><table class=\"list\"><thead><tr>" + head + "</tr></thead><tbody>\n";
  for (std::size_t i = 0; i < std::min(count, kMostRows); ++i) html += "<tr>" + row(i) + "</tr>\n";
  if (count > kMostRows) {
    html += fmt::format("<tr><td colspan=\"{}\">and {} more</td></tr>\n", columns,
                        with_thousands(static_cast<std::int64_t>(count - kMostRows)));
  }
  return html + "</tbody></table></div>\n";
}

std::string change_table(const LocalizationResult& result) {
  std::string html = "<h2>Changes of state</h2>\n";
  if (result.changes.empty()) return html + "<p>There was none.</p>\n";
  return html + list_of(
                    "<th class=\"n\">time</th><th>state</th><th class=\"n\">probability</th>"
                    "<th class=\"n\">explained</th><th class=\"n\">through walls</th>"
                    "<th class=\"n\">path</th><th class=\"n\">x, y, yaw</th>",
                    7, result.changes.size(), [&](std::size_t i) {
                      const LocalizationChange& change = result.changes[i];
                      std::string cells =
                          fmt::format("<td class=\"n\">{}</td><td>{}</td>",
                                      since_start(result, change.stamp), state_chip(change.state));
                      const LocalizationEstimate* e = estimate_at(result, change.stamp);
                      if (e == nullptr) return cells + "<td colspan=\"5\"></td>";
                      return cells + fmt::format(
                                         "<td class=\"n\">{}</td><td class=\"n\">{}</td>"
                                         "<td class=\"n\">{}</td><td class=\"n\">{:.1f} m</td>"
                                         "<td class=\"n\">{}</td>",
                                         percent(e->probability), percent(e->evidence.explained),
                                         percent(e->evidence.violations), e->travelled_m,
                                         pose_text(e->map_T_robot));
                    });
}

std::string search_table(const LocalizationResult& result) {
  std::string html = "<h2>Searches of the map</h2>\n";
  if (result.searches.empty()) return html + "<p>None was needed.</p>\n";
  html +=
      "<p class=\"soft\">Found: poses that explain the scan about as well as the best; new: of "
      "them, places that nothing was known of; best: share of the scan that the best "
      "explains.</p>\n";
  return html + list_of(
                    "<th class=\"n\">time</th><th>reason</th><th>where</th>"
                    "<th class=\"n\">found</th><th class=\"n\">new</th><th "
                    "class=\"n\">best</th>",
                    6, result.searches.size(), [&](std::size_t i) {
                      const LocalizationSearch& search = result.searches[i];
                      return fmt::format(
                          "<td class=\"n\">{}</td><td>{}</td><td>{}</td><td "
                          "class=\"n\">{}</td><td class=\"n\">{}</td><td "
                          "class=\"n\">{}</td>",
                          since_start(result, search.stamp), escape_html(search.reason),
                          search.whole_map ? "whole map" : "near the pose", search.poses_found,
                          search.poses_added, percent(search.best_score));
                    });
}

}  // namespace

std::string format_localization_report(const LocalizationResult& result,
                                       const Grid<std::int8_t>& occupancy,
                                       const LocalizationRunInfo& info, std::string_view map_png,
                                       const std::vector<ListedFile>& files) {
  const LocalizationFigures figures = figures_of(result);
  std::string body = "<p class=\"verdict\">" + verdict(result, figures, info) + "</p>\n";
  body += html_warnings(result.warnings);
  body += html_figure(
      html_picture(map_png, "map", "The map with the robot's path"),
      "The path is blue where the robot was sure of its pose (TRACKING), thick amber where it had "
      "doubts (DOUBTFUL), dotted pink where it knew nothing better (LOST). Green: particles at the "
      "times shown.");
  body += "<h2>Key figures</h2>\n" + key_figures(result, occupancy, figures, info);
  if (const std::string plots = localization_plots(result); !plots.empty()) {
    body += "<h2>Over time</h2>\n<p class=\"soft\">The ground shows the state: " +
            state_chip(LocalizationState::kTracking) + " " +
            state_chip(LocalizationState::kDoubtful) + " " + state_chip(LocalizationState::kLost) +
            ". Long runs are drawn in 800 steps, each with its worst value.</p>\n" + plots;
  }
  body += moments(result, occupancy);
  body += change_table(result) + search_table(result);
  body += html_options(info.run) + html_file_list(files);
  return html_page("Localisation of " + log_name(info.run), body, info.run);
}

}  // namespace loopstone
