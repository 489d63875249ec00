#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "loopstone/base/stamp.hpp"
#include "loopstone/messages/message_codec.hpp"

// Containers of recorded messages, written. Nothing appears under the final name before finish().

namespace loopstone {

/// What a container is told of a topic that it is to hold.
struct WrittenTopic {
  std::string name{};  ///< "/scan"
  std::string type{};  ///< canonical
  std::string ros1_definition{};
  std::string ros2_definition{};
  std::string md5{};
  std::string rihs01{};
  bool latched = false;  ///< who comes late gets the last message: /tf_static, /map
};

/// All that WrittenTopic says of a type.
template <typename M>
[[nodiscard]] WrittenTopic written_topic(const std::string& name, bool latched = false) {
  using Type = MessageType<M>;
  return {.name = name,
          .type = Type::name(),
          .ros1_definition = Type::ros1_definition(),
          .ros2_definition = Type::ros2_definition(),
          .md5 = Type::md5(),
          .rihs01 = Type::rihs01(),
          .latched = latched};
}

class RecordingWriter {
 public:
  virtual ~RecordingWriter() = default;
  /// In which the messages are to be: ROS 1 for a bag, CDR for the others.
  [[nodiscard]] virtual WireFormat wire_format() const = 0;
  /// The number of the topic for write().
  [[nodiscard]] virtual std::size_t add_topic(const WrittenTopic& topic) = 0;
  /// Stamps need not be in order. Throws DataError when it can't be written.
  virtual void write(std::size_t topic, Stamp recorded, std::span<const char> bytes) = 0;
  /// Completes the file and puts it in its place. Without it the destructor removes what was
  /// written.
  virtual void finish() = 0;
};

/// MCAP, profile "ros2": chunks of zstd, message and chunk indexes, statistics, summary.
[[nodiscard]] std::unique_ptr<RecordingWriter> create_mcap(const std::string& path);
/// A ROS 1 bag v2.0: chunks of lz4, indexed.
[[nodiscard]] std::unique_ptr<RecordingWriter> create_bag(const std::string& path);
/// A folder of rosbag2: NAME_0.db3 (schema version 4) and metadata.yaml (version 9), as ROS 2 Jazzy
/// writes them.
[[nodiscard]] std::unique_ptr<RecordingWriter> create_rosbag2(const std::string& folder);

}  // namespace loopstone
