#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "commands.hpp"
#include "log_run.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/report/map_figures.hpp"
#include "loopstone/report/map_outputs.hpp"
#include "loopstone/report/peak_memory.hpp"
#include "loopstone/report/site_grids.hpp"
#include "loopstone/report/site_outputs.hpp"
#include "loopstone/report/site_recording.hpp"
#include "loopstone/version.hpp"
#include "map_text.hpp"
#include "output_path.hpp"
#include "result.hpp"
#include "run_recording.hpp"
#include "site.hpp"

namespace loopstone::app {

namespace {

constexpr const char* kMapFooter = R"(
OUT then holds what `loopstone map` writes, of all sessions that are joined, drawn as they agree now: a wall that was moved is gone
once two visits in a row saw through it. Beside it movable.png and movable.pgm: where visits are not of one mind, such as doors and
chairs, and how often something stood there. coverage.png (sessions that saw the floor, and how long ago), travel.png (where robots
drove, how often and how fast) and glass.png (surfaces that are suspected to be glass), each with grids as map_server reads them.
graph.g2o is the pose graph of all sessions, and sessions.csv says which nodes and which trajectory are whose; `loopstone optimize`
reads it. --mcap FILE leaves map, paths, closures and poses for Foxglove. `loopstone localize LOG --map OUT` uses the map,
`loopstone export SITE` draws it as a plan.)";

constexpr const char* kChangesFooter = R"(
OUT then holds changes.png and changes.csv (metres of the map). Dates are those of the sessions: what the last ones
until each date agreed on. Sessions that newer ones have replaced are gone: the oldest that are kept then count.)";

struct Arguments {
  std::string site;
  std::string out;
  std::string mcap;
  std::string date;
  std::string from;
  bool force = false;
};

Stamp date_of(const std::string& flag, const std::string& text) {
  return read_date(flag, text, parse_utc_end);
}

Outputs outputs_of(const Arguments& arguments, const AppContext& context) {
  Outputs outputs(context, arguments.force);
  outputs.reads(arguments.site);
  outputs.add_folder("-o", arguments.out);
  if (!arguments.mcap.empty()) outputs.add_file("--mcap", arguments.mcap);
  outputs.check();
  return outputs;
}

RunInfo info_of(const Site& site, const Arguments& arguments,
                std::chrono::steady_clock::time_point start, const AppContext& context) {
  RunInfo info = run_info(arguments.site, {}, arguments.force, context);
  info.options_toml = site.file().options_toml();
  info.cpu_time_s = cpu_seconds();
  info.peak_memory_bytes = peak_memory_bytes();
  info.wall_time_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return info;
}

/// A recording that can't be written must not take the map with it. \return why there is none
std::string record(const SiteMap& map, const std::string& path) {
  if (path.empty()) return {};
  return failure_of([&] { write_site_recording(map.result, map.sessions, map.movable, path); });
}

/// Of pieces that were set by hand and that nobody will see.
void warn_of(std::span<const SiteCorrection> edits, const AppContext& context) {
  for (const SiteCorrection& one : edits) {
    if (one.edit.kind == SiteEditKind::kExclude || one.cells > 0) continue;
    context.warn(fmt::format("edit {} lies {}: nothing of it is drawn", one.edit.id,
                             one.on_map ? "beside the map" : "on what is no part of the map"));
  }
}

ExitCode run_map(const Arguments& arguments, const AppContext& context) {
  const auto start = std::chrono::steady_clock::now();
  std::optional<Stamp> until;
  if (!arguments.date.empty()) until = date_of("--date", arguments.date);
  const Outputs outputs = outputs_of(arguments, context);
  const Site site(arguments.site, SiteAccess::kRead, context.threads());
  const SiteMap map = site.map(until, {.grids = true});
  outputs.prepare();
  RunInfo info = info_of(site, arguments, start, context);
  info.failure = record(map, arguments.mcap);
  const SiteFigures figures = figures_of(*map.grids, map.result.map, map.edits);
  warn_of(map.edits, context);
  const MapExtras extras{.site = &figures};
  write_map_outputs(map.result, info, arguments.out, extras);
  write_site_grids(*map.grids, figures, map.movable, map.result.map, arguments.out,
                   context.threads());
  write_site_sessions(map.result, map.sessions, arguments.out);
  return tell_map(map.result, extras, info, {.out = arguments.out, .mcap = arguments.mcap},
                  context);
}

ExitCode run_changes(const Arguments& arguments, const AppContext& context) {
  const Stamp from = date_of("--from", arguments.from);
  std::optional<Stamp> to;
  if (!arguments.date.empty()) to = date_of("--to", arguments.date);
  if (to && *to < from) throw UsageError("--to lies before --from");
  const Outputs outputs = outputs_of(arguments, context);
  const Site site(arguments.site, SiteAccess::kRead, context.threads());
  const Site::Difference difference = site.difference(from, to);
  outputs.prepare();
  write_changes(difference.changes, difference.before, difference.now.result.map, arguments.out,
                arguments.force);
  Result result;
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  int appeared = 0;
  for (const MapChange& change : difference.changes) {
    appeared += change.appeared ? 1 : 0;
    rows.push_back(nlohmann::ordered_json{{"appeared", change.appeared},
                                          {"x_m", {change.low.x(), change.high.x()}},
                                          {"y_m", {change.low.y(), change.high.y()}},
                                          {"area_m2", change.area_m2}});
  }
  const int gone = static_cast<int>(difference.changes.size()) - appeared;
  result.add("appeared", "appeared", appeared).add("gone", "gone", gone);
  const auto pieces = std::ranges::count_if(
      difference.now.edits, [](const SiteCorrection& edit) { return edit.on_map.has_value(); });
  result.add_json("edits", json_of(difference.now.edits));
  if (pieces > 0)
    result.add_row("by hand", fmt::format("{} pieces set; what is in them never changes", pieces));
  result.add_json("changes", std::move(rows)).add_row("picture", arguments.out + "/changes.png");
  result.print(context);
  return kExitDone;
}

}  // namespace

void add_site_map_commands(CLI::App& site, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = site.add_subcommand("map", "The map of a site, of today or of a date");
  command->add_option("SITE", arguments->site, "its file")->required();
  command
      ->add_option("-o,--out", arguments->out,
                   "folder for the results; made, or empty unless --force")
      ->required();
  command
      ->add_option("--date", arguments->date,
                   "as the building was then, UTC: by the sessions until the end of this day")
      ->type_name("DATE");
  command
      ->add_option("--mcap", arguments->mcap,
                   "also write it as a recording, for Foxglove, Lichtblick or RViz")
      ->type_name("FILE");
  add_force_flag(*command, arguments->force);
  context.add_common_flags(*command);
  context.add_threads_flag(*command);
  command->footer(kMapFooter);
  context.on_run(*command, [arguments, &context] { return run_map(*arguments, context); });

  auto dates = std::make_shared<Arguments>();
  command = site.add_subcommand("changes", "What appeared in a building, and what is gone");
  command->add_option("SITE", dates->site, "its file")->required();
  command
      ->add_option("-o,--out", dates->out, "folder for the pictures; made, or empty unless --force")
      ->required();
  command->add_option("--from", dates->from, "since this date, UTC")->type_name("DATE")->required();
  command->add_option("--to", dates->date, "until this one (default: today)")->type_name("DATE");
  add_force_flag(*command, dates->force);
  context.add_common_flags(*command);
  context.add_threads_flag(*command);
  command->footer(kChangesFooter);
  context.on_run(*command, [dates, &context] { return run_changes(*dates, context); });
}

}  // namespace loopstone::app
