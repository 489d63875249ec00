#include "program.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>
#include <string>

#include "interrupt.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "progress_display.hpp"
#include "terminal_text.hpp"

namespace loopstone::app {

namespace {

int fail(const CLI::App& app, ExitCode code, const char* reason) {
  ProgressDisplay::clear_line();
  std::fprintf(stderr, "%s: %s\n", app.get_name().c_str(), terminal_text(reason).c_str());
  return code;
}

}  // namespace

void begin_program(const char* name) {
  spdlog::set_default_logger(spdlog::stderr_color_mt(name));
  spdlog::set_pattern("%^%l%$: %v");
  listen_for_interrupts();
}

int run_program(CLI::App& app, const std::function<ExitCode()>& run) {
  try {
    return run();
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    return fail(app, kExitBadUsage, error.what());
  } catch (const UsageError& error) {
    return fail(app, kExitBadUsage, error.what());
  } catch (const ReadingStopped& stopped) {
    return fail(app, kExitInterrupted, stopped.what());
  } catch (const std::bad_alloc&) {
    return fail(app, kExitBadData, "out of memory");
  } catch (const std::exception& error) {
    return fail(app, kExitBadData, error.what());
  }
}

}  // namespace loopstone::app
