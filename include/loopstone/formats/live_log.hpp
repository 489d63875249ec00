#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "loopstone/formats/log_reader.hpp"

namespace loopstone {

/// How a connection is named: tcp://HOST:PORT.
inline constexpr std::string_view kTcpScheme = "tcp://";

/// A log that is in the making, as it comes (LogOptions::live, which need not be set): what can be
/// read from a pipe, CARMEN's lines and MCAP before all.
///
/// MCAP has to be written without chunks, or with small ones: what stands in a chunk comes when the
/// chunk is whole.
/// \param source  "-", the standard input; a pipe; a file, which is read from its beginning on and
///                then followed while it grows; tcp://HOST:PORT, a connection that is made
/// Throws DataError when there is nothing at the source, or no such log; UsageError for a
/// connection that is not named so; ReadingStopped.
[[nodiscard]] std::unique_ptr<LogReader> open_live_log(const std::string& source,
                                                       const LogOptions& options = {});

}  // namespace loopstone
