#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "loopstone/base/stamp.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {

/// A message of ROS 2 as it came, by whatever way.
struct CameMessage {
  std::string topic{};  ///< "/scan"
  std::string type{};   ///< canonical: "sensor_msgs/LaserScan"
  Stamp received{};     ///< by this machine's clock
  std::string bytes{};  ///< CDR with its 4 bytes of encapsulation, as encode_message() writes it
};

/// Gives the next message. Nothing: none came within the time that it waits for one, which should
/// be some hundredths of a second. Throws DataError when none will come any more.
using TakeMessage = std::function<std::optional<CameMessage>()>;

/// A log of what somebody is told over a network, as it comes (LogOptions::live, which need not be
/// set): topics are chosen, mounts and clocks found as in a recording with these topics. Pictures
/// are left out. It ends when LogOptions::stop says so.
/// \param name  for messages to the user
/// Throws UsageError for topics that the user named and that did not come; ReadingStopped.
[[nodiscard]] std::unique_ptr<LogReader> open_message_log(const std::string& name, TakeMessage take,
                                                          const LogOptions& options = {});

}  // namespace loopstone
