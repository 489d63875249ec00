#include "site.hpp"

#include <memory>

#include "commands.hpp"
#include "interrupt.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone::app {

namespace {

constexpr const char* kFooter = R"(
A SITE is one file: what the sessions of one building have led to, and the map that they make together. A session is a drive of
any robot on any day; it is found on the site by itself, or kept beside it until a later one ties it. docs/sites.md tells more.

Examples:
  loopstone site add office.site monday.mcap tuesday.bag    makes the site, or adds to it
  loopstone site show office.site                           its sessions, and what became of each
  loopstone site map office.site -o out                     the map of today, as `loopstone map` writes one
  loopstone site changes office.site --from 2026-10-01 -o changes
                                                            what appeared and what is gone since then
  loopstone site edit office.site --wall "1,2 4,2 4,2.1 1,2.1"
                                                            a glass wall that no laser sees; `--undo` takes it back)";

}  // namespace

SiteWatch site_watch(const AppContext& context) {
  return {.progress = [](const Progress&) { return !interrupted(); },
          .waits =
              [&context, told = false]() mutable {
                if (!told) context.note("another program writes this site; waiting for it");
                told = true;
                return !interrupted();
              }};
}

Stamp read_date(const std::string& flag, const std::string& text,
                std::optional<Stamp> (*parse)(const std::string&)) {
  if (const auto date = parse(text)) return *date;
  throw UsageError(flag + ": " + text + " is no date; write 2026-11-26 or 2026-11-26T14:03");
}

nlohmann::ordered_json json_of(const SiteSession& session) {
  return {{"id", session.id},
          {"log", session.log},
          {"digest", session.digest},
          {"begins", utc_text(session.begins)},
          {"added", session.added},
          {"status", to_string(session.status)},
          {"reason", session.reason},
          {"closures", session.closures},
          {"scans", session.scans},
          {"path_m", session.path_m},
          {"duration_s", session.duration_s},
          {"verdict", session.verdict},
          {"sentence", session.sentence}};
}

void add_site_command(CLI::App& app, AppContext& context) {
  CLI::App* site =
      app.add_subcommand("site", "One map of a building from many drives, kept true as it changes");
  site->require_subcommand(1);
  add_site_add_command(*site, context);
  add_site_map_commands(*site, context);
  add_site_show_commands(*site, context);
  add_site_edit_commands(*site, context);
  add_site_care_commands(*site, context);
  site->footer(kFooter);
}

}  // namespace loopstone::app
