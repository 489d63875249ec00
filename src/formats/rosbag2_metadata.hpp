#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/stamp.hpp"

// metadata.yaml of a recording by rosbag2.

namespace loopstone {

/// What is used of it. All versions (1 to 9) say it alike; none of it is to be relied on.
struct Rosbag2Metadata {
  int version = 0;
  std::string storage{};             ///< "sqlite3", "mcap"
  std::vector<std::string> files{};  ///< as written: relative to the folder, or not
  std::string compression_mode{};    ///< "file", "message" or nothing, in small letters
  std::string compression_format{};  ///< "zstd"
  /// Messages by topic; topics that stand twice are left out.
  std::map<std::string, std::int64_t, std::less<>> messages{};
};

/// Throws DataError with the line when it can't be understood.
[[nodiscard]] Rosbag2Metadata parse_rosbag2_metadata(std::string_view text,
                                                     const std::string& path = "metadata.yaml");

/// What a writer knows of what it has written.
struct Rosbag2Contents {
  struct Topic {
    std::string name{};
    std::string type{};  ///< of ROS 2: "sensor_msgs/msg/LaserScan"
    std::string hash{};
    bool latched = false;
    std::int64_t messages = 0;
  };
  std::string storage{};
  std::string file{};
  std::vector<Topic> topics{};
  std::int64_t messages = 0;
  Stamp first{};  ///< of the messages, when there are any
  Stamp last{};
};

/// metadata.yaml, version 9.
[[nodiscard]] std::string format_rosbag2_metadata(const Rosbag2Contents& contents);
/// The same without its first line and one step to the left, as it is kept within a recording.
[[nodiscard]] std::string format_inner_rosbag2_metadata(const Rosbag2Contents& contents);

/// The list of one profile of quality of service that a publisher offers, as text: reliable, and
/// transient local when latched.
[[nodiscard]] std::string format_qos_profiles(bool latched);

}  // namespace loopstone
