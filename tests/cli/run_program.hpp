#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

namespace loopstone::test {

struct ProgramResult {
  int exit_code = -1;  ///< 128 + signal when a signal ended it
  std::string out;
  std::string error;
};

/// Runs the built program with these arguments and no standard input.
[[nodiscard]] ProgramResult run_program(const std::vector<std::string>& arguments);

/// The same with standard output going to a file, such as /dev/full.
[[nodiscard]] ProgramResult run_program_into(const std::string& out_path,
                                             const std::vector<std::string>& arguments);

/// The same, with Ctrl-C as soon as this file or folder exists.
[[nodiscard]] ProgramResult interrupt_program(const std::string& when_exists,
                                              const std::vector<std::string>& arguments);

/// The same, with Ctrl-C as soon as it has opened this named pipe, out of which nothing ever comes.
[[nodiscard]] ProgramResult interrupt_reader(const std::string& pipe,
                                             const std::vector<std::string>& arguments);

/// The same, with Ctrl-C when `action` has returned.
/// \param action  is given what tells what stands in the standard error so far
[[nodiscard]] ProgramResult interrupt_after(
    const std::vector<std::string>& arguments,
    const std::function<void(const std::function<std::string()>& errors)>& action);

/// The same, ended by SIGKILL after so long unless it was faster.
[[nodiscard]] ProgramResult kill_program(std::chrono::milliseconds after,
                                         const std::vector<std::string>& arguments);

/// The same, with `action` done while it runs, as soon as this file or folder exists.
[[nodiscard]] ProgramResult disturb_program(const std::string& when_exists,
                                            const std::function<void()>& action,
                                            const std::vector<std::string>& arguments);

/// How many lines a text has.
[[nodiscard]] std::size_t count_lines(const std::string& text);

}  // namespace loopstone::test
