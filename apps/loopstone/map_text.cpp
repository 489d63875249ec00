#include "map_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "loopstone/report/map_figures.hpp"
#include "map_landmarks.hpp"
#include "result.hpp"

namespace loopstone::app {

namespace {

void add_site_rows(const SiteFigures& site, Result& table) {
  const CoverageFigures& floor = site.floor;
  const double percent = floor.free_m2 > 0.0 ? 100.0 / floor.free_m2 : 0.0;
  table.add_row("seen by the newest session",
                fmt::format("{:.0f} % of the free area", percent * floor.free_seen_by_newest_m2));
  const double never_m2 = floor.free_never_driven_m2();
  table.add_row("never driven", fmt::format("{:.0f} %, {:.1f} m2", percent * never_m2, never_m2));
  if (site.speed_m_s) table.add_row("speed", fmt::format("{:.2f}", *site.speed_m_s), "m/s");
  double glass_m = 0.0;
  for (const GlassPane& pane : site.panes) glass_m += pane.length_m();
  table.add_row("glass suspected", fmt::format("{} panes, {:.1f} m", site.panes.size(), glass_m));
  if (site.edits.empty()) return;
  const auto pieces = std::ranges::count_if(
      site.edits, [](const SiteEditFigure& e) { return e.cells.has_value(); });
  table.add_row("by hand", fmt::format("{} sessions left out, {} pieces set",
                                       std::ssize(site.edits) - pieces, pieces));
}

void print_result(const MapResult& result, const MapExtras& extras, const RunInfo& info,
                  const MapPlaces& places, const AppContext& context) {
  if (context.json()) {
    print_to_stdout(format_summary(result, info, extras));
    return;
  }
  const MapStatistics& s = result.statistics;
  Result table;
  table.add("scans", "scans", s.scans);
  if (info.left_out.skipped.records > 0) {
    table.add_row("records skipped",
                  fmt::format("{} of {}", info.left_out.skipped.records, info.left_out.records()));
  }
  table.add("duration_s", "recording", s.duration_s, "s", 1);
  table.add("path_length_m", "path", s.path_length_m, "m", 1);
  table.add("map_free_area_m2", "free area mapped", figures_of(result.map).free_area_m2, "m2", 1);
  if (extras.site != nullptr) add_site_rows(*extras.site, table);
  table.add("submaps", "submaps", s.submaps);
  table.add_row("loop closures", fmt::format("{} accepted, {} rejected", s.loop_closures_accepted,
                                             s.loop_closures_rejected));
  if (!result.verdict.sentence.empty()) table.add_row("quality", result.verdict.sentence);
  if (extras.landmarks != nullptr) add_landmark_rows(*extras.landmarks, table);
  if (extras.texture != nullptr) add_texture_rows(*extras.texture, table);
  table.add_row("time", fmt::format("{:.2f} s, {:.0f} x real time", info.wall_time_s,
                                    s.duration_s / std::max(info.wall_time_s, 1e-9)));
  if (info.pace) {
    const auto row = [&](const char* title, const LatencyFigures& figures) {
      table.add_row(
          title, fmt::format("{:.2f} ms, 99 % within {:.1f} ms, worst {:.1f} ms",
                             1e3 * figures.median_s, 1e3 * figures.p99_s, 1e3 * figures.worst_s));
    };
    row("pose after", info.pace->arrival);
    row("of it computing", info.pace->computing);
  }
  table.add_row("peak memory",
                fmt::format("{:.0f}", static_cast<double>(info.peak_memory_bytes) * 1e-6), "MB");
  if (!places.mcap.empty() && info.failure.empty()) table.add_row("mcap", places.mcap);
  table.add_row("report", places.out + "/report.html");
  table.print(context);
}

}  // namespace

ExitCode tell_map(const MapResult& result, const MapExtras& extras, const RunInfo& info,
                  const MapPlaces& places, const AppContext& context) {
  for (const auto& warning : result.warnings) context.warn(warning);
  print_result(result, extras, info, places, context);
  if (!info.failure.empty())
    throw std::runtime_error(info.failure + "; all else is in " + places.out);
  if (result.complete) return kExitDone;
  context.warn("interrupted: the map is of what was read until then" + places.goes_on);
  return kExitInterrupted;
}

}  // namespace loopstone::app
