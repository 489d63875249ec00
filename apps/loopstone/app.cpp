#include "app.hpp"

#include <spdlog/spdlog.h>

#include <atomic>
#include <csignal>
#include <filesystem>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "progress_display.hpp"

namespace loopstone::app {

namespace {

// A signal handler can reach nothing but a global.
std::atomic<bool> interrupt_requested{false};

extern "C" void on_interrupt(int signal) {
  if (interrupt_requested.exchange(true)) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

}  // namespace

void install_interrupt_handler() {
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
}

void AppContext::set_command_line(int argc, const char* const* argv) {
  command_line_ = "loopstone";
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool plain = word.find_first_of(" \t\"'$&|;<>*?()") == std::string::npos && !word.empty();
    command_line_ += plain ? " " + word : " '" + word + "'";
  }
}

bool AppContext::interrupted() { return interrupt_requested.load(); }

void AppContext::add_common_flags(CLI::App& command) {
  command.add_flag("--json", json_, "print the result as one JSON object on stdout");
  command.add_flag("-q,--quiet", quiet_, "no progress and no notes, warnings and errors only");
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

RobotModel AppContext::robot() const {
  return robot_path_.empty() ? RobotModel{} : read_robot_file(robot_path_);
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
  spdlog::info("{}", text);
}

void AppContext::warn(const std::string& text) const {
  ProgressDisplay::clear_line();
  spdlog::warn("{}", text);
}

void prepare_output_folder(const std::string& path, bool force) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (fs::exists(path, error) && !fs::is_directory(path, error)) {
    throw UsageError(path + ": is a file; the output needs a folder");
  }
  fs::create_directories(path, error);
  if (error) throw DataError({path}, "cannot make the folder: " + error.message());
  const bool empty = fs::is_empty(path, error);
  if (error) throw DataError({path}, "cannot look into the folder: " + error.message());
  if (!empty && !force) {
    throw UsageError(path + ": is not empty; choose another folder or add --force to overwrite");
  }
}

}  // namespace loopstone::app
