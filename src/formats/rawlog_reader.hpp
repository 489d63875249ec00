#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "formats/byte_source.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {

/// Lasers of one rawlog that are told apart, by their labels.
inline constexpr int kRawlogLidars = 16;

/// Reads a rawlog of MRPT, in the form of actions and sensory frames or of observations. Throws
/// DataError when it holds neither a scan nor odometry, saying what it holds; of a long file only
/// the beginning is looked at for that.
[[nodiscard]] std::unique_ptr<LogReader> open_rawlog(const ReadableBytes& log,
                                                     const LogOptions& options);

/// The same over bytes in memory, which must outlive the reader.
[[nodiscard]] std::unique_ptr<LogReader> read_rawlog(std::string_view bytes,
                                                     const LogOptions& options,
                                                     const std::string& name = "memory");

}  // namespace loopstone
