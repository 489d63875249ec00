#include "run_program.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <stdexcept>
#include <thread>

#include "program_paths.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {

namespace {

/// In the child: this descriptor becomes that file.
void redirect(int descriptor, const char* path, int flags) {
  const int file = ::open(path, flags, 0600);
  if (file < 0 || ::dup2(file, descriptor) < 0) ::_exit(127);
}

void wait_until_exists(const std::string& path) {
  constexpr auto kPause = std::chrono::milliseconds(2);
  constexpr int kMostPauses = 30'000;
  for (int i = 0; i < kMostPauses && !std::filesystem::exists(path); ++i)
    std::this_thread::sleep_for(kPause);
}

/// \param while_running  called in the parent with the child's process id
/// \param folder         for its standard error
ProgramResult run(const std::string& out_path, const std::vector<std::string>& arguments,
                  const std::function<void(pid_t)>& while_running, const TempDir& folder = {}) {
  const std::string error_path = folder / "stderr";
  std::vector<char*> argv;
  std::string program = LOOPSTONE_PROGRAM;
  std::vector<std::string> copies = arguments;
  argv.push_back(program.data());
  for (std::string& argument : copies) argv.push_back(argument.data());
  argv.push_back(nullptr);

  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child == 0) {
    redirect(STDIN_FILENO, "/dev/null", O_RDONLY);
    redirect(STDOUT_FILENO, out_path.c_str(), O_WRONLY | O_CREAT | O_TRUNC);
    redirect(STDERR_FILENO, error_path.c_str(), O_WRONLY | O_CREAT | O_TRUNC);
    ::execv(program.c_str(), argv.data());
    ::_exit(127);
  }
  if (while_running) while_running(child);
  int status = 0;
  ::waitpid(child, &status, 0);
  ProgramResult result;
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.error = folder.read("stderr");
  return result;
}

}  // namespace

ProgramResult run_program_into(const std::string& out_path,
                               const std::vector<std::string>& arguments) {
  return run(out_path, arguments, {});
}

ProgramResult interrupt_program(const std::string& when_exists,
                                const std::vector<std::string>& arguments) {
  const TempDir folder;
  ProgramResult result = run(folder / "stdout", arguments, [&](pid_t child) {
    wait_until_exists(when_exists);
    ::kill(child, SIGINT);  // not yet waited for, so the id is still its own
  });
  result.out = folder.read("stdout");
  return result;
}

ProgramResult interrupt_reader(const std::string& pipe, const std::vector<std::string>& arguments) {
  const TempDir folder;
  int held_open = -1;
  ProgramResult result = run(folder / "stdout", arguments, [&](pid_t child) {
    constexpr int kMostTries = 5'000;
    for (int i = 0; i < kMostTries && held_open < 0; ++i) {
      held_open = ::open(pipe.c_str(), O_WRONLY | O_NONBLOCK);  // refused while nobody reads
      if (held_open < 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    ::kill(child, SIGINT);
  });
  if (held_open >= 0) ::close(held_open);
  result.out = folder.read("stdout");
  return result;
}

ProgramResult interrupt_after(
    const std::vector<std::string>& arguments,
    const std::function<void(const std::function<std::string()>& errors)>& action) {
  const TempDir folder;
  const TempDir errors;
  ProgramResult result = run(
      folder / "stdout", arguments,
      [&](pid_t child) {
        try {
          action([&] { return errors.read("stderr"); });
        } catch (const std::exception& error) {
          ::kill(child, SIGINT);
          throw;
        }
        ::kill(child, SIGINT);
      },
      errors);
  result.out = folder.read("stdout");
  return result;
}

ProgramResult kill_program(std::chrono::milliseconds after,
                           const std::vector<std::string>& arguments) {
  const TempDir folder;
  return run(folder / "stdout", arguments, [&](pid_t child) {
    const auto end = std::chrono::steady_clock::now() + after;
    siginfo_t state{};
    // WNOWAIT: who has ended is still there to be waited for.
    while (std::chrono::steady_clock::now() < end &&
           ::waitid(P_PID, static_cast<id_t>(child), &state, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           state.si_pid == 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ::kill(child, SIGKILL);
  });
}

ProgramResult disturb_program(const std::string& when_exists, const std::function<void()>& action,
                              const std::vector<std::string>& arguments) {
  const TempDir folder;
  return run(folder / "stdout", arguments, [&](pid_t) {
    wait_until_exists(when_exists);
    action();
  });
}

ProgramResult run_program(const std::vector<std::string>& arguments) {
  const TempDir folder;
  ProgramResult result = run_program_into(folder / "stdout", arguments);
  result.out = folder.read("stdout");
  return result;
}

std::size_t count_lines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

}  // namespace loopstone::test
