#include "live_sources.hpp"

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "loopstone/base/error.hpp"
#include "loopstone/devices/scanner.hpp"
#include "loopstone/formats/live_log.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/live/scanner_source.hpp"
#include "paced_log.hpp"

namespace loopstone::app {

namespace {

constexpr std::string_view kReplay = "replay:";
constexpr std::string_view kStandardInput = "-";

LiveSource replay(const std::string& name, double speed) {
  const std::string log = name.substr(kReplay.size());
  return {.name = log,
          .open =
              [log, speed](const LogOptions& how) {
                return std::make_unique<PacedLog>(open_log(log, how), speed, how.stop);
              },
          .is_opened_again = false};
}

/// A connection, or the pipe of another program, may come back; a file that has ended has ended.
LiveSource stream(const std::string& name) {
  std::error_code ignored;
  const bool comes_back = name.starts_with(kTcpScheme) || std::filesystem::is_fifo(name, ignored);
  return {.name = name == kStandardInput ? "standard input" : name,
          .open = [name](const LogOptions& how) { return open_live_log(name, how); },
          .is_opened_again = comes_back};
}

LiveSource source_of(const std::string& name, double speed) {
  if (name.starts_with(kReplay)) return replay(name, speed);
  if (is_scanner_address(name)) return scanner_source(name);
  const std::size_t scheme = name.find("://");
  if (scheme != std::string::npos && !name.starts_with(kTcpScheme)) {
    throw UsageError(
        "--source " + name +
        ": is no kind of source; there are tcp://HOST:PORT, scip:// and rplidar:// for "
        "scanners, replay:LOG, and the names of pipes and files");
  }
  return stream(name);
}

}  // namespace

std::vector<LiveSource> live_sources(const LiveArguments& arguments) {
  if (std::ranges::count(arguments.sources, kStandardInput) > 1)
    throw UsageError("--source -: the standard input can be one source only");
  std::vector<LiveSource> sources;
  for (const std::string& name : arguments.sources)
    sources.push_back(source_of(name, arguments.speed));
  sources.insert(sources.end(), arguments.given.begin(), arguments.given.end());
  return sources;
}

std::string names_of_sources(const LiveArguments& arguments) {
  std::string names;
  for (const std::string& name : arguments.sources) names += (names.empty() ? "" : ", ") + name;
  for (const LiveSource& source : arguments.given)
    names += (names.empty() ? "" : ", ") + source.name;
  return names;
}

}  // namespace loopstone::app
