#include <fmt/format.h>

#include <memory>

#include "commands.hpp"
#include "info_text.hpp"
#include "log_run.hpp"
#include "loopstone/formats/log_format_words.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/log_summary.hpp"
#include "progress_display.hpp"
#include "result.hpp"

namespace loopstone::app {

namespace {

struct Arguments {
  std::string log;
  LogFlags reading;
  bool formats = false;
};

constexpr const char* kFooter = R"(
Reads the whole log once and says what is in it, what is wrong with it, and whether a map can be
made of it. The first ten broken records are named on stderr.

Examples:
  loopstone info intel.clf
  loopstone info data/ucsd#20 --json
  loopstone info --formats)";

ExitCode run(const Arguments& arguments, AppContext& context) {
  if (arguments.formats) {
    print_to_stdout(context.json() ? log_formats_json() : log_formats_text());
    return kExitDone;
  }
  constexpr int kProblemsShown = 10;
  int problems = 0;
  LogOptions options = log_options(arguments.reading, context);
  options.on_problem = [&](const Problem& problem) {
    if (++problems <= kProblemsShown) {
      context.warn(to_string(problem.location) + ": " + problem.reason);
    }
  };
  options.topics.count_all = true;
  const auto log = open_log(arguments.log, options);
  ProgressDisplay display(context);
  const LogSummary summary = analyse_log(*log, display.callback());
  ProgressDisplay::clear_line();
  if (problems > kProblemsShown) {
    context.warn(fmt::format("and {} more problems of this kind", problems - kProblemsShown));
  }
  print_to_stdout(context.json() ? log_summary_json(summary, arguments.log)
                                 : info_text(arguments.log, summary));
  return summary.complete ? kExitDone : kExitInterrupted;
}

}  // namespace

void add_info_command(CLI::App& app, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("info", "Show what is in a log and what is wrong with it");
  CLI::Option* const log =
      command->add_option("LOG", arguments->log, "a log file or folder")->required();
  const auto ask_for_formats = [arguments, log] {
    arguments->formats = true;
    log->required(false);
  };
  command->add_flag_callback("--formats", ask_for_formats, "the formats of logs, without a LOG")
      ->trigger_on_parse();
  arguments->reading.pictures = true;
  add_log_flags(*command, arguments->reading);
  context.add_common_flags(*command);
  command->footer(kFooter);
  context.on_run(*command, [arguments, &context] { return run(*arguments, context); });
}

}  // namespace loopstone::app
