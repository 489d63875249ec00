#pragma once

#include <functional>

#include "app.hpp"

// What the programs have in common before and after their commands.

namespace loopstone::app {

/// Before any other thread is there: messages to the user, Ctrl-C.
void begin_program(const char* name);

/// Runs what the user asked for, and turns what it throws into a line on stderr and an exit code.
/// \param run  parses the command line first
[[nodiscard]] int run_program(CLI::App& app, const std::function<ExitCode()>& run);

}  // namespace loopstone::app
