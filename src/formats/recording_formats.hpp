#pragma once

#include <memory>
#include <string>
#include <vector>

#include "loopstone/formats/log_format.hpp"
#include "loopstone/odometry/trajectory.hpp"

// The containers' functions in the table of log formats.

namespace loopstone {

[[nodiscard]] Recognition recognise_bag(const LogInput& log);
[[nodiscard]] std::unique_ptr<LogReader> open_bag_log(const LogInput& log,
                                                      const LogOptions& options);
[[nodiscard]] std::unique_ptr<LogWriter> create_bag_log(const LogTarget& target,
                                                        const RobotModel& robot);
[[nodiscard]] Trajectory bag_truth(const LogInput& log, const std::string& topic,
                                   const LogOptions& options);

[[nodiscard]] Recognition recognise_mcap(const LogInput& log);
[[nodiscard]] std::unique_ptr<LogReader> open_mcap_log(const LogInput& log,
                                                       const LogOptions& options);
[[nodiscard]] std::unique_ptr<LogWriter> create_mcap_log(const LogTarget& target,
                                                         const RobotModel& robot);
[[nodiscard]] Trajectory mcap_truth(const LogInput& log, const std::string& topic,
                                    const LogOptions& options);

/// A folder with metadata.yaml or databases, or one database.
[[nodiscard]] Recognition recognise_rosbag2(const LogInput& log);
[[nodiscard]] std::unique_ptr<LogReader> open_rosbag2_log(const LogInput& log,
                                                          const LogOptions& options);
[[nodiscard]] std::vector<std::string> rosbag2_log_files(const LogInput& log);
[[nodiscard]] std::unique_ptr<LogWriter> create_rosbag2_log(const LogTarget& target,
                                                            const RobotModel& robot);
[[nodiscard]] LogParts rosbag2_parts(const LogTarget& target);
[[nodiscard]] Trajectory rosbag2_truth(const LogInput& log, const std::string& topic,
                                       const LogOptions& options);

}  // namespace loopstone
