#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "commands.hpp"
#include "interrupt.hpp"
#include "log_run.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/option_list.hpp"
#include "loopstone/formats/options_file.hpp"
#include "progress_display.hpp"
#include "result.hpp"
#include "site.hpp"

namespace loopstone::app {

namespace {

constexpr const char* kFooter = R"(
Each LOG is mapped by itself, as `loopstone map` does it, and looked for on the site without a guess:
  joined    it was recognised, and is part of the map
  pending   it was not, or in more than one place; it waits beside the map until a later session ties it
  refused   its own map is bad; only that is noted
In which order sessions are added changes nothing: they are joined in the order in which they were driven. What is in the site
already is left out. A new site keeps the options of -c and --set for all its maps. Ctrl-C leaves out the session in the making.

Examples:
  loopstone site add office.site monday.mcap tuesday.mcap
  loopstone site add office.site old.clf --date 2003-05-12     a log whose stamps tell no date)";

struct Arguments {
  std::string site;
  std::vector<std::string> logs;
  std::string date;
  LogFlags reading;
};

std::optional<Stamp> date_of(const Arguments& arguments) {
  if (arguments.date.empty()) return {};
  const auto date = parse_utc(arguments.date);
  if (!date)
    throw UsageError("--date: " + arguments.date + " is no date; write 2026-11-26 or 2026-11-26T14:03");
  if (arguments.logs.size() > 1)
    throw UsageError("--date is of one log; add the others by commands of their own");
  return date;
}

void make_site(const std::string& path, const AppContext& context) {
  MapOptions options = context.load_options(MapOptions{});
  if (!std::filesystem::exists(path))
    SiteFile::create(path, options_to_toml(list_options(options)));
}

struct Added {
  SiteSession session{};
  double map_s = 0.0;
  double join_s = 0.0;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Added add_log(Site& site, const std::string& log, const Arguments& arguments,
              const AppContext& context) {
  ProblemPrinter print_problem(context);
  LogFlags flags = arguments.reading;
  flags.pictures = false;
  const LogSource source = source_of(log, log_options(flags, context, &print_problem), context);
  const auto reader = source.open_ahead(context.threads());
  tell_choices(*reader, context);
  ProgressDisplay display(context);
  const auto start = std::chrono::steady_clock::now();
  const MappedSession mapped = map_session(source, *reader, site.options(), context.threads(),
                                           date_of(arguments), watch_by(display));
  ProgressDisplay::clear_line();
  Added added{.map_s = seconds_since(start)};
  if (!mapped.complete || interrupted()) throw UsageError(log + ": was called off; the site stays as it was");
  const auto mapped_at = std::chrono::steady_clock::now();
  added.session = site.add(mapped, site_watch(context));
  added.join_s = seconds_since(mapped_at);
  return added;
}

void add_row(const Added& added, Result& result) {
  const SiteSession& session = added.session;
  result.add_row(
      session.log,
      fmt::format("{}{}; its own map is {}; mapped in {:.1f} s, looked for in {:.1f} s",
                  to_string(session.status),
                  session.status == SessionStatus::kJoined
                      ? fmt::format(", tied by {} closures", session.closures)
                      : ": " + session.reason,
                  session.verdict, added.map_s, added.join_s));
}

bool has_log(const Site& site, const std::string& log) {
  const std::string path = std::filesystem::absolute(log).string();
  for (const SiteSession& session : site.sessions())
    if (session.log == path) return true;
  return false;
}

ExitCode run(const Arguments& arguments, const AppContext& context) {
  (void)date_of(arguments);
  make_site(arguments.site, context);
  const HeldInterrupt held("interrupted: the site stays as it is; once more ends it at once");
  Site site(arguments.site, SiteAccess::kWrite, context.threads());
  Result result;
  nlohmann::ordered_json sessions = nlohmann::ordered_json::array();
  bool failed = false;
  for (const std::string& log : arguments.logs) {
    if (interrupted()) return kExitInterrupted;
    if (has_log(site, log)) context.note(log + ": a log of this name is in the site already");
    try {
      const Added added = add_log(site, log, arguments, context);
      nlohmann::ordered_json row = json_of(added.session);
      row["map_s"] = added.map_s;
      row["join_s"] = added.join_s;
      sessions.push_back(std::move(row));
      add_row(added, result);
    } catch (const std::runtime_error& error) {
      if (arguments.logs.size() == 1) throw;
      if (interrupted()) return kExitInterrupted;
      context.warn(error.what());
      failed = true;
    }
  }
  result.add_json("site", arguments.site).add_json("sessions", std::move(sessions));
  result.print(context);
  return failed ? kExitBadData : kExitDone;
}

}  // namespace

void add_site_add_command(CLI::App& site, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = site.add_subcommand("add", "Map logs and join them to a site");
  command->add_option("SITE", arguments->site, "its file; made where there is none")->required();
  command
      ->add_option("LOG", arguments->logs,
                   "log files, or folders (DIR#20 names set 20 of a UCSD folder)")
      ->required();
  command
      ->add_option("--date", arguments->date,
                   "when the log was recorded, UTC (default: as its stamps say)")
      ->type_name("DATE");
  add_log_flags(*command, arguments->reading);
  context.add_common_flags(*command);
  context.add_threads_flag(*command);
  context.add_option_flags(*command);
  context.add_robot_flag(*command);
  command->footer(kFooter);
  context.on_run(*command, [arguments, &context] { return run(*arguments, context); });
}

}  // namespace loopstone::app
