#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dds_node.hpp"
#include "loopstone/formats/topic_options.hpp"
#include "loopstone/live/live_log.hpp"

namespace loopstone::app {

/// Topics that a robot tells its sensors on.
struct SensorTopics {
  std::vector<std::string> scans{"/scan"};
  std::vector<std::string> odometry{"/odom"};  ///< beside it there is tf
  std::vector<std::string> imu{};
  std::vector<std::string> awaited{};  ///< those that a drive can't begin without
};

/// Of the defaults, and of what the user named in their place. Throws UsageError for a role that
/// is not filled over the network.
[[nodiscard]] SensorTopics sensor_topics(const TopicOptions& options);

/// A robot's sensors as a source of a LiveLog. It is open when each awaited topic has had a
/// message. \param node  must outlive it
[[nodiscard]] LiveSource ros2_source(const DdsNode& node, const std::string& name,
                                     const SensorTopics& topics);

}  // namespace loopstone::app
