#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "interrupt.hpp"
#include "loopstone/base/error.hpp"
#include "result.hpp"
#include "site.hpp"

namespace loopstone::app {

namespace {

constexpr const char* kFooter = R"(
One edit a command; none of them touches what a session is made of, and each can be undone:
  --exclude ID     leaves a session out: the map is as if it had never been there. It stays in the site
  --include ID     takes it back into the map
  --free POLYGON   what lies in the polygon is free in every map, plan and recording that is made of the site, whatever was seen there
  --wall POLYGON   or stands there; --unknown POLYGON: or is not known
  --undo N         takes back edit N, by the numbers of `site edits`
A POLYGON is its corners in metres of the map, in one word: "x1,y1 x2,y2 x3,y3 ...". It goes with the building when the map
moves. Where polygons overlap, the later edit counts.

Examples:
  loopstone site map office.site -o out                            to read coordinates from out/map.png
  loopstone site edit office.site --wall "1,2 4,2 4,2.1 1,2.1"     a glass wall that no laser sees
  loopstone site edit office.site --exclude 3
  loopstone site edit office.site --undo 1)";

struct Arguments {
  std::string site;
  std::optional<std::int64_t> exclude;
  std::optional<std::int64_t> include;
  std::optional<std::int64_t> undo;
  std::optional<std::string> free;
  std::optional<std::string> wall;
  std::optional<std::string> unknown;
};

nlohmann::ordered_json row_of(const SiteCorrection& edit) {
  nlohmann::ordered_json row{
      {"edit", edit.edit.id}, {"at", edit.edit.at}, {"kind", to_string(edit.edit.kind)}};
  if (edit.edit.kind == SiteEditKind::kExclude) {
    row["session"] = edit.edit.excluded;
    return row;
  }
  row["polygon"] = nullptr;
  if (!edit.on_map) return row;
  row["polygon"] = nlohmann::ordered_json::array();
  for (const Eigen::Vector2d& corner : edit.on_map->corners)
    row["polygon"].push_back({corner.x(), corner.y()});
  row["area_m2"] = area_of(*edit.on_map);
  return row;
}

std::string told(const SiteCorrection& edit, const std::vector<SiteSession>& sessions) {
  if (edit.edit.kind == SiteEditKind::kExclude) {
    for (const SiteSession& session : sessions) {
      if (session.id == edit.edit.excluded)
        return fmt::format("session {} ({})", session.id,
                           std::filesystem::path(session.log).filename().string());
    }
  }
  if (!edit.on_map) return "lies on what is no part of the map";
  std::string text = fmt::format("{:.2f} m2:", area_of(*edit.on_map));
  constexpr std::size_t kShown = 6;
  const auto& corners = edit.on_map->corners;
  for (std::size_t i = 0; i < std::min(kShown, corners.size()); ++i)
    text += fmt::format(" {:.3f},{:.3f}", corners[i].x(), corners[i].y());
  if (corners.size() > kShown) text += fmt::format(" and {} more", corners.size() - kShown);
  return text;
}

using Action = std::function<std::int64_t(Site&, const SiteWatch&)>;

Polygon2 polygon_of(const std::string& flag, const std::string& text) {
  try {
    return parse_polygon(text);
  } catch (const UsageError& error) {
    throw UsageError(fmt::format("{}: {}", flag, error.what()));
  }
}

/// What is asked for; the polygons are read already.
std::vector<Action> actions_of(const Arguments& arguments) {
  std::vector<Action> actions;
  if (const auto id = arguments.exclude)
    actions.emplace_back(
        [id](Site& site, const SiteWatch& watch) { return site.exclude(*id, watch).id; });
  if (const auto id = arguments.include)
    actions.emplace_back(
        [id](Site& site, const SiteWatch& watch) { return site.include(*id, watch).id; });
  if (const auto id = arguments.undo)
    actions.emplace_back([id](Site& site, const SiteWatch& watch) {
      site.undo(*id, watch);
      return *id;
    });
  const auto add = [&](const char* flag, const std::optional<std::string>& text,
                       SiteEditKind kind) {
    if (!text) return;
    actions.emplace_back(
        [kind, polygon = polygon_of(flag, *text)](Site& site, const SiteWatch& watch) {
          return site.set_cells(kind, polygon, watch).id;
        });
  };
  add("--free", arguments.free, SiteEditKind::kFree);
  add("--wall", arguments.wall, SiteEditKind::kWall);
  add("--unknown", arguments.unknown, SiteEditKind::kUnknown);
  return actions;
}

ExitCode edit(const Arguments& arguments, const AppContext& context) {
  const std::vector<Action> actions = actions_of(arguments);
  if (actions.size() != 1) {
    throw UsageError(
        "give one of --exclude, --include, --free, --wall, --unknown and --undo; each is an edit "
        "of its own");
  }
  const HeldInterrupt held("interrupted: the site stays as it is; once more ends it at once");
  Site site(arguments.site, SiteAccess::kWrite, context.threads());
  const std::int64_t id = actions.front()(site, site_watch(context));
  const bool is_undone = arguments.include || arguments.undo;
  Result result;
  result.add("edit", is_undone ? "edit undone" : "edit", id);
  const std::vector<SiteCorrection> edits = site.edits();
  result.add("edits", "edits of the site", edits.size());
  const std::vector<SiteSession> sessions = site.sessions();
  result.add("joined", "sessions joined",
             std::ranges::count(sessions, SessionStatus::kJoined, &SiteSession::status));
  result.print(context);
  return kExitDone;
}

ExitCode list(const std::string& path, const AppContext& context) {
  const Site site(path, SiteAccess::kRead, context.threads());
  const std::vector<SiteCorrection> edits = site.edits();
  const std::vector<SiteSession> sessions = site.sessions();
  Result result;
  result.add_row("", fmt::format("{:>4}  {:<20}  {:<7}  {}", "edit", "done", "kind", "what"));
  for (const SiteCorrection& one : edits) {
    result.add_row("", fmt::format("{:>4}  {:<20}  {:<7}  {}", one.edit.id, one.edit.at,
                                   to_string(one.edit.kind), told(one, sessions)));
  }
  result.add_json("edits", json_of(edits));
  result.print(context);
  return kExitDone;
}

}  // namespace

nlohmann::ordered_json json_of(std::span<const SiteCorrection> edits) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const SiteCorrection& one : edits) rows.push_back(row_of(one));
  return rows;
}

void add_site_edit_commands(CLI::App& site, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      site.add_subcommand("edit", "Correct a site by hand; all of it can be undone");
  command->add_option("SITE", arguments->site, "its file")->required();
  command->add_option("--exclude", arguments->exclude, "leave out this session, by `site show`")
      ->type_name("ID");
  command->add_option("--include", arguments->include, "take it back into the map")
      ->type_name("ID");
  command->add_option("--free", arguments->free, "what lies in a polygon is free")
      ->type_name("POLYGON");
  command->add_option("--wall", arguments->wall, "or stands there")->type_name("POLYGON");
  command->add_option("--unknown", arguments->unknown, "or is not known")->type_name("POLYGON");
  command->add_option("--undo", arguments->undo, "take back this edit, by `site edits`")
      ->type_name("N");
  context.add_common_flags(*command);
  context.add_threads_flag(*command);
  command->footer(kFooter);
  context.on_run(*command, [arguments, &context] { return edit(*arguments, context); });

  auto path = std::make_shared<std::string>();
  command = site.add_subcommand("edits", "What was corrected in a site by hand");
  command->add_option("SITE", *path, "its file")->required();
  context.add_common_flags(*command);
  context.on_run(*command, [path, &context] { return list(*path, context); });
}

}  // namespace loopstone::app
