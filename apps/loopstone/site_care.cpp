#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "interrupt.hpp"
#include "result.hpp"
#include "site.hpp"

namespace loopstone::app {

namespace {

struct Arguments {
  std::string site;
  std::vector<std::int64_t> sessions;
  bool pending = false;
};

ExitCode prune(const Arguments& arguments, const AppContext& context) {
  const HeldInterrupt held("interrupted: the site stays as it is; once more ends it at once");
  const SitePruning pruning = prune_site(arguments.site, arguments.sessions, arguments.pending,
                                         context.threads(), site_watch(context));
  Result result;
  result.add("removed", "sessions removed", pruning.removed)
      .add("bytes_before", "size before", pruning.bytes_before, "bytes")
      .add("bytes", "size now", pruning.bytes, "bytes");
  result.print(context);
  return kExitDone;
}

ExitCode rebuild(const Arguments& arguments, const AppContext& context) {
  const HeldInterrupt held("interrupted: the site stays as it is; once more ends it at once");
  Site site(arguments.site, SiteAccess::kWrite, context.threads());
  site.rebuild(site_watch(context));
  int joined = 0;
  const std::vector<SiteSession> sessions = site.sessions();
  for (const SiteSession& session : sessions)
    joined += session.status == SessionStatus::kJoined ? 1 : 0;
  Result result;
  result.add("sessions", "sessions", sessions.size()).add("joined", "joined", joined);
  result.print(context);
  return kExitDone;
}

}  // namespace

void add_site_care_commands(CLI::App& site, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = site.add_subcommand("prune", "Remove sessions, and give back their room");
  command->add_option("SITE", arguments->site, "its file")->required();
  command->add_option("--session", arguments->sessions, "these, by the ids of `site show`")
      ->type_name("ID");
  command->add_flag("--pending", arguments->pending, "all that are pending");
  context.add_common_flags(*command);
  context.add_threads_flag(*command);
  context.on_run(*command, [arguments, &context] { return prune(*arguments, context); });

  auto whole = std::make_shared<Arguments>();
  command = site.add_subcommand("rebuild", "Find all that ties the sessions of a site anew");
  command->add_option("SITE", whole->site, "its file")->required();
  context.add_common_flags(*command);
  context.add_threads_flag(*command);
  context.on_run(*command, [whole, &context] { return rebuild(*whole, context); });
}

}  // namespace loopstone::app
