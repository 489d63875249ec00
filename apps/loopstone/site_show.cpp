#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "loopstone/base/error.hpp"
#include "result.hpp"
#include "site.hpp"

namespace loopstone::app {

namespace {

struct Arguments {
  std::string site;
  bool ties = false;
};

/// What was found between two sessions: closures by what became of them, and why.
std::map<std::string, int> counts_of(const DrivePair& pair) {
  std::map<std::string, int> counts;
  for (const LoopClosure& closure : pair.closures) {
    const std::string_view reason = to_string(closure.reason);
    ++counts[std::string(to_string(closure.state)) +
             (reason.empty() ? "" : ": " + std::string(reason))];
  }
  return counts;
}

void add_ties(const SiteFile& file, Result& result) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  result.add_row("", "ties between sessions");
  for (const SitePair& pair : file.pairs()) {
    if (pair.older == pair.newer) continue;
    nlohmann::ordered_json counts = nlohmann::ordered_json::object();
    std::string text;
    for (const auto& [word, count] : counts_of(pair.pair)) {
      counts[word] = count;
      text += fmt::format("{}{} {}", text.empty() ? "" : "; ", count, word);
    }
    rows.push_back(nlohmann::ordered_json{
        {"older", pair.older}, {"newer", pair.newer}, {"closures", std::move(counts)}});
    result.add_row("", fmt::format("{:>4} - {:<4}  {}", pair.older, pair.newer,
                                   text.empty() ? "nothing looks alike" : text));
  }
  result.add_json("ties", std::move(rows));
}

ExitCode show(const Arguments& arguments, const AppContext& context) {
  const Site site(arguments.site, SiteAccess::kRead, context.threads());
  Result result;
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  int joined = 0;
  double path_m = 0.0;
  result.add_row("", fmt::format("{:>4}  {:<20}  {:<8}  {:>8}  {:>9}  {:<9}  {}", "id", "driven",
                                 "status", "closures", "path [m]", "own map", "log"));
  for (const SiteSession& session : site.sessions()) {
    rows.push_back(json_of(session));
    joined += session.status == SessionStatus::kJoined ? 1 : 0;
    path_m += session.path_m;
    result.add_row("", fmt::format("{:>4}  {:<20}  {:<8}  {:>8}  {:>9.1f}  {:<9}  {}", session.id,
                                   utc_text(session.begins), to_string(session.status),
                                   session.closures, session.path_m, session.verdict,
                                   std::filesystem::path(session.log).filename().string()));
    if (!session.reason.empty()) result.add_row("", fmt::format("{:>4}  {}", "", session.reason));
  }
  if (arguments.ties) add_ties(site.file(), result);
  const std::vector<SiteCorrection> edits = site.edits();
  if (!edits.empty()) result.add_row("edits by hand", fmt::format("{}", edits.size()));
  result.add("joined", "sessions joined", joined)
      .add("path_m", "driven, all sessions", path_m, "m", 1)
      .add_json("edits", json_of(edits))
      .add("bytes", "size of the site", site.file().bytes(), "bytes")
      .add_json("sessions", std::move(rows));
  result.add_json("numbers", numbers_json(site_numbers()));
  result.print(context);
  return kExitDone;
}

ExitCode history(const Arguments& arguments, const AppContext& context) {
  const SiteFile file(arguments.site, SiteAccess::kRead);
  Result result;
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const SiteEvent& event : file.events()) {
    rows.push_back(nlohmann::ordered_json{
        {"at", event.at}, {"what", event.what}, {"log", event.session}, {"text", event.text}});
    const std::string name = std::filesystem::path(event.session).filename().string();
    result.add_row("", fmt::format("{}  {:<8}  {}{}{}", event.at, event.what, name,
                                   name.empty() || event.text.empty() ? "" : ": ", event.text));
  }
  result.add_json("events", std::move(rows));
  result.print(context);
  return kExitDone;
}

ExitCode check(const Arguments& arguments, const AppContext& context) {
  const SiteFile file(arguments.site, SiteAccess::kRead);
  const std::vector<std::string> problems = file.check();
  Result result;
  result.add("sound", "sound", problems.empty());
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const std::string& problem : problems) {
    rows.push_back(problem);
    result.add_row("", problem);
  }
  result.add_json("problems", std::move(rows));
  result.print(context);
  if (!problems.empty()) {
    throw DataError({arguments.site}, fmt::format("this site is damaged: {}", problems.front()));
  }
  return kExitDone;
}

using Action = ExitCode (*)(const Arguments&, const AppContext&);

std::shared_ptr<Arguments> add_command(CLI::App& site, AppContext& context, const char* name,
                                       const char* text, Action action) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = site.add_subcommand(name, text);
  command->add_option("SITE", arguments->site, "its file")->required();
  context.add_common_flags(*command);
  context.on_run(*command, [arguments, action, &context] { return action(*arguments, context); });
  return arguments;
}

}  // namespace

void add_site_show_commands(CLI::App& site, AppContext& context) {
  const auto arguments =
      add_command(site, context, "show", "The sessions of a site, and what became of each", show);
  site.get_subcommand("show")->add_flag("--ties", arguments->ties,
                                        "also what was found between each two of them");
  add_command(site, context, "history", "What was done to a site, and when", history);
  add_command(site, context, "check", "Whether a site's file is sound; exit code 1 when it is not",
              check);
}

}  // namespace loopstone::app
