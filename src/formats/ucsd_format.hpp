#pragma once

#include <memory>
#include <string>
#include <vector>

#include "loopstone/formats/log_format.hpp"

// The UCSD layout's functions in the table of log formats.

namespace loopstone {

/// A folder with a sensor's file of any set, or an archive.
[[nodiscard]] Recognition recognise_ucsd(const LogInput& log);
/// An archive stands for the set in its name, of the folder that it lies in.
[[nodiscard]] std::unique_ptr<LogReader> open_ucsd(const LogInput& log, const LogOptions& options);
/// Of the sensors; pictures are left out.
[[nodiscard]] std::vector<std::string> ucsd_log_files(const LogInput& log);
[[nodiscard]] std::unique_ptr<LogWriter> create_ucsd(const LogTarget& target,
                                                     const RobotModel& robot);
[[nodiscard]] LogParts ucsd_parts(const LogTarget& target);

}  // namespace loopstone
