#include "app.hpp"

#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/machine_memory.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "progress_display.hpp"
#include "terminal_text.hpp"

namespace loopstone::app {

void AppContext::set_command_line(const std::string& program, int argc, const char* const* argv) {
  command_line_ = program;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool plain = word.find_first_of(" \t\"'$&|;<>*?()") == std::string::npos && !word.empty();
    command_line_ += plain ? " " + word : " '" + word + "'";
  }
}

void AppContext::add_common_flags(CLI::App& command) {
  command.add_flag("--json", json_, "print the result as one JSON object on stdout");
  command.add_flag("-q,--quiet", quiet_,
                   "no progress and no notes on stderr, warnings and errors only");
  command
      .add_option(
          "--max-memory", max_memory_,
          "memory that what a file holds may take, such as 2G (default: by the file's size, "
          "up to three quarters of the machine's)")
      ->type_name("SIZE");
}

void AppContext::add_threads_flag(CLI::App& command) {
  command
      .add_option("--threads", threads_,
                  "threads to use; the result is the same with any number (0: one per processor)")
      ->type_name("N")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
}

void AppContext::add_option_flags(CLI::App& command) {
  command
      .add_option("-c,--config", options_path_,
                  "options as TOML; `loopstone config` prints all of them")
      ->type_name("FILE.toml");
  command
      .add_option("--set", assignments_,
                  "one option; beats the file, which beats the default; may be given several times")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
}

void AppContext::add_robot_flag(CLI::App& command) {
  command
      .add_option("--robot", robot_path_,
                  "wheels and sensor mounts as TOML (default: robots/ucsd.toml)")
      ->type_name("FILE.toml");
}

void AppContext::on_run(CLI::App& command, std::function<ExitCode()> action) {
  command.callback([this, action = std::move(action)] { action_ = action; });
}

MemoryBudget AppContext::memory() const {
  if (max_memory_.empty()) return machine_memory_budget();
  try {
    return {.ceiling_bytes = parse_bytes(max_memory_), .by_file_size = false};
  } catch (const UsageError& error) {
    throw UsageError(std::string("--max-memory ") + error.what());
  }
}

RobotModel AppContext::robot() const {
  return robot_path_.empty() ? RobotModel{} : read_robot_file(robot_path_);
}

StatedWheels AppContext::stated_wheels() const {
  return robot_path_.empty() ? StatedWheels{} : read_stated_wheels(robot_path_);
}

void AppContext::override_options(const std::vector<OptionEntry>& options) const {
  std::vector<OptionProblem> problems;
  if (!options_path_.empty()) problems = apply_options_file(options, options_path_);
  for (const std::string& assignment : assignments_) {
    for (OptionProblem& problem : apply_assignment(options, assignment)) {
      problems.push_back(std::move(problem));
    }
  }
  if (!problems.empty()) throw OptionsError(std::move(problems));
}

void override_option(const std::vector<OptionEntry>& options, const std::string& flag,
                     const std::string& assignment, std::vector<OptionProblem>& problems) {
  for (OptionProblem& problem : apply_assignment(options, assignment)) {
    problem.where.path = flag;
    problems.push_back(std::move(problem));
  }
}

void AppContext::note(const std::string& text) const {
  if (quiet_) return;
  ProgressDisplay::clear_line();
  spdlog::info("{}", terminal_text(text));
}

void AppContext::warn(const std::string& text) const {
  ProgressDisplay::clear_line();
  spdlog::warn("{}", terminal_text(text));
}

}  // namespace loopstone::app
