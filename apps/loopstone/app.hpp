#pragma once

// What every subcommand shares: flags, exit codes, option files, messages to the user.
//
// A subcommand is one file with one function, listed in commands.hpp and main.cpp:
//
//   void add_info_command(CLI::App& app, AppContext& context) {
//     struct Arguments { std::string log; };
//     auto arguments = std::make_shared<Arguments>();
//     CLI::App* command = app.add_subcommand("info", "Show what is in a log");
//     command->add_option("LOG", arguments->log, "a log file or folder")->required();
//     context.add_common_flags(*command);
//     context.on_run(*command, [arguments, &context] { return run_info(*arguments, context); });
//   }
//
// run_info returns an ExitCode and reports failure by throwing DataError or UsageError; main()
// turns that into one line on stderr and the exit code.

#include <functional>
#include <string>
#include <vector>

#include "loopstone/base/memory_budget.hpp"
#include "loopstone/base/parallel_for.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/formats/topic_options.hpp"
#include "loopstone/sensor/robot_model.hpp"

// Not its header, which costs seconds in every file that reads it (commands.hpp has it).
namespace CLI {  // NOLINT(readability-identifier-naming): the library's own name
class App;
}

namespace loopstone::app {

enum ExitCode : int {
  kExitDone = 0,
  kExitBadData = 1,
  kExitBadUsage = 2,
  kExitBoundMissed = 3,    ///< a --require bound
  kExitInterrupted = 130,  ///< by Ctrl-C; what is written says that it is incomplete
};

class AppContext {
 public:
  /// --json, --quiet, --max-memory.
  void add_common_flags(CLI::App& command);
  /// --threads.
  void add_threads_flag(CLI::App& command);
  /// -c FILE.toml, --set key=value.
  void add_option_flags(CLI::App& command);
  /// --robot FILE.
  void add_robot_flag(CLI::App& command);

  /// What main() calls when the user asked for this command.
  void on_run(CLI::App& command, std::function<ExitCode()> action);

  [[nodiscard]] bool json() const { return json_; }
  [[nodiscard]] bool quiet() const { return quiet_; }
  /// What each file may take in memory: --max-memory, else by the machine and the file's size.
  [[nodiscard]] MemoryBudget memory() const;
  [[nodiscard]] Threads threads() const { return Threads{threads_}; }

  /// The defaults of an option struct (one with visit_options), overridden by -c, overridden by
  /// --set.
  /// Throws OptionsError with all problems of the file and the flags together.
  template <typename Options>
  [[nodiscard]] Options load_options(Options options = {}) const {
    override_options(list_options(options));
    return options;
  }

  /// The robot of --robot, else the default one.
  [[nodiscard]] RobotModel robot() const;
  /// What its file says of the wheels; nothing without --robot.
  [[nodiscard]] StatedWheels stated_wheels() const;
  /// True when the user named a robot; its file then beats what a log says about itself.
  [[nodiscard]] bool robot_given() const { return !robot_path_.empty(); }
  /// The files of -c and --robot; empty names where they are not given.
  [[nodiscard]] std::vector<std::string> option_paths() const {
    return {options_path_, robot_path_};
  }

  /// What the user typed, for the report.
  [[nodiscard]] const std::string& command_line() const { return command_line_; }
  void set_command_line(const std::string& program, int argc, const char* const* argv);

  /// One line of the log on stderr, not in the way of the progress bar. note() is silent with
  /// --quiet.
  void note(const std::string& text) const;
  void warn(const std::string& text) const;

  [[nodiscard]] ExitCode run() const { return action_(); }

 private:
  void override_options(const std::vector<OptionEntry>& options) const;

  bool json_ = false;
  bool quiet_ = false;
  int threads_ = 0;
  std::string max_memory_;
  std::string options_path_;
  std::vector<std::string> assignments_;
  std::string robot_path_;
  std::string command_line_;
  std::function<ExitCode()> action_;
};

/// Writes a flag's value into the option of this key, held to the option's own rule; what is wrong
/// joins the problems under the flag's name.
void override_option(const std::vector<OptionEntry>& options, const std::string& flag,
                     const std::string& assignment, std::vector<OptionProblem>& problems);

}  // namespace loopstone::app
