#pragma once

#include <string>

#include "loopstone/live/live_log.hpp"

namespace loopstone {

/// A scanner on the wire as a source of a LiveLog: devices/scanner.hpp tells its addresses. Its
/// laser is taken to sit at the robot's centre and to look ahead.
[[nodiscard]] LiveSource scanner_source(const std::string& address);

}  // namespace loopstone
