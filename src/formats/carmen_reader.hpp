#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "formats/byte_source.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/odometry/trajectory.hpp"

namespace loopstone {

/// Reads a CARMEN log, plain or compressed by gzip or bzip2. Throws DataError when no line of it
/// can be understood, saying why not the first.
[[nodiscard]] std::unique_ptr<LogReader> open_carmen_log(const ReadableBytes& log,
                                                         const LogOptions& options);

/// The same over bytes in memory, which must outlive the reader.
[[nodiscard]] std::unique_ptr<LogReader> read_carmen_log(std::string_view bytes,
                                                         const LogOptions& options,
                                                         const std::string& name = "memory");

/// The poses of the TRUEPOS lines: of a simulator's robot in its world. Throws DataError for
/// another topic, and when there are none.
[[nodiscard]] Trajectory read_carmen_truth(const ReadableBytes& log, const std::string& topic,
                                           const LogOptions& options);

}  // namespace loopstone
