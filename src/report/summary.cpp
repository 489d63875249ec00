#include "report/summary.hpp"

#include <nlohmann/json.hpp>

#include "formats/left_out_json.hpp"
#include "loopstone/report/map_outputs.hpp"
#include "report/calibration_summary.hpp"
#include "report/edit_summary.hpp"
#include "report/fault_summary.hpp"
#include "report/landmark_summary.hpp"
#include "report/quality_summary.hpp"
#include "report/texture_summary.hpp"

namespace loopstone {

MapFigures figures_of(const OccupancyMap& map) {
  const GridFrame& frame = map.observed.frame();
  std::int64_t known = 0;
  std::int64_t free = 0;
  for (std::size_t i = 0; i < map.observed.cells().size(); ++i) {
    if (map.observed.cells()[i] == 0) continue;
    ++known;
    if (map.log_odds.cells()[i] < 0.0F) ++free;
  }
  const double cell_m2 = frame.resolution * frame.resolution;
  return {static_cast<double>(known) * cell_m2, static_cast<double>(free) * cell_m2,
          frame.columns * frame.resolution, frame.rows * frame.resolution};
}

namespace {

using Json = nlohmann::ordered_json;

Json pace_json(const PaceFigures& pace) {
  return {{"speed", pace.speed},
          {"median_latency_s", pace.arrival.median_s},
          {"p99_latency_s", pace.arrival.p99_s},
          {"worst_latency_s", pace.arrival.worst_s},
          {"median_computing_s", pace.computing.median_s},
          {"p99_computing_s", pace.computing.p99_s},
          {"worst_computing_s", pace.computing.worst_s}};
}

Json site_json(const SiteFigures& site) {
  const CoverageFigures& floor = site.floor;
  const double never_driven_m2 = floor.free_never_driven_m2();
  Json glass = Json::array();
  for (const GlassPane& pane : site.panes) {
    glass.push_back(Json{{"x_m", {pane.low.x(), pane.high.x()}},
                         {"y_m", {pane.low.y(), pane.high.y()}},
                         {"length_m", pane.length_m()},
                         {"probability", pane.probability}});
  }
  Json edits = Json::array();
  for (const SiteEditFigure& edit : site.edits) {
    edits.push_back(Json{{"edit", edit.edit}, {"kind", edit.kind}});
    if (edit.cells) edits.back()["cells"] = *edit.cells;
  }
  return {
      {"sessions", site.sessions},
      {"free_m2", floor.free_m2},
      {"free_seen_by_newest_m2", floor.free_seen_by_newest_m2},
      {"free_seen_by_newest_share", ratio_or_zero(floor.free_seen_by_newest_m2, floor.free_m2)},
      {"free_never_driven_m2", never_driven_m2},
      {"free_never_driven_share", ratio_or_zero(never_driven_m2, floor.free_m2)},
      {"most_passes", site.most_passes},
      {"speed_m_s", optional_number(site.speed_m_s)},
      {"speed_low_m_s", optional_number(site.speed_low_m_s)},
      {"speed_high_m_s", optional_number(site.speed_high_m_s)},
      {"glass", glass},
      {"edits", edits},
  };
}

/// What every run has.
Json summary_json(const MapResult& result, const RunInfo& info) {
  const MapStatistics& s = result.statistics;
  const MapFigures map = figures_of(result.map);
  // Key order is the order of this list. A number that is not finite becomes null.
  return {
      {"version", info.version},
      {"log", info.log_path},
      {"command", info.command_line},
      {"complete", result.complete && info.failure.empty()},
      {"scans", s.scans},
      {"scans_dropped", s.scans_dropped},
      {"records_skipped", info.left_out.skipped.records},
      {"left_out", to_json(info.left_out)},
      {"key_scans", s.key_scans},
      {"key_scans_thinned", s.key_scans_thinned},
      {"submaps", s.submaps},
      {"searches", s.searches},
      {"loop_closures_accepted", s.loop_closures_accepted},
      {"loop_closures_rejected", s.loop_closures_rejected},
      {"path_length_m", s.path_length_m},
      {"degenerate_travel_m", s.degenerate_travel_m},
      {"odometry_distrusted_s", s.odometry_distrusted_s},
      {"odometry_jumps", s.odometry_jumps},
      {"odometry_translation_scale", s.odometry_translation_scale},
      {"odometry_rotation_scale", s.odometry_rotation_scale},
      {"duration_s", s.duration_s},
      {"wall_time_s", info.wall_time_s},
      {"cpu_time_s", info.cpu_time_s},
      {"front_end_wall_s", s.front_end_s},
      {"loop_closing_wall_s", s.loop_closing_s},
      {"optimisation_wall_s", s.optimisation_s},
      {"adjustment_wall_s", s.adjustment_s},
      {"rendering_wall_s", s.rendering_s},
      {"judging_wall_s", s.judging_s},
      {"realtime_factor", ratio_or_zero(s.duration_s, info.wall_time_s)},
      {"scans_per_s", ratio_or_zero(static_cast<double>(s.scans), info.wall_time_s)},
      {"threads", info.threads},
      {"peak_memory_bytes", info.peak_memory_bytes},
      {"map_area_m2", map.known_area_m2},
      {"map_free_area_m2", map.free_area_m2},
      {"map_width_m", map.width_m},
      {"map_height_m", map.height_m},
      {"map_resolution_m", result.map.log_odds.frame().resolution},
      {"graph_nodes", result.graph.poses.size()},
      {"graph_edges", result.graph.edges.size()},
      {"graph_cost", s.graph_cost},
      {"surface_spread_before_m", s.surface_spread_before_m},
      {"surface_spread_m", s.surface_spread_m},
      {"quality", quality_json(result)},
      {"calibration", calibration_json(result.calibration)},
      {"odometry_faults", odometry_faults(result)},
      {"laser_faults", laser_faults(result)},
      {"path_breaks", path_breaks(result)},
      {"warnings", result.warnings},
      {"log_warnings", info.log_warnings},
  };
}

}  // namespace

std::string format_summary(const MapResult& result, const RunInfo& info, const MapExtras& extras) {
  Json summary = summary_json(result, info);
  for (const auto& [name, term] : info.terms) summary["result_of"][name] = term;
  if (!result.drives.empty()) summary["drives"] = drives_json(result);
  if (!info.failure.empty()) summary["warnings"].push_back(info.failure);
  if (info.pace) summary["realtime"] = pace_json(*info.pace);
  if (extras.texture != nullptr) summary["texture"] = texture_json(*extras.texture);
  if (extras.landmarks != nullptr) summary["landmarks"] = landmarks_json(*extras.landmarks);
  if (extras.edits != nullptr) summary["edits"] = edits_json(*extras.edits);
  if (extras.site != nullptr) summary["site"] = site_json(*extras.site);
  // Paths need not be UTF-8; JSON must.
  return summary.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace loopstone
