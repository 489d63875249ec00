#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "loopstone/formats/message_log.hpp"
#include "loopstone/messages/message_codec.hpp"

// Topics of ROS 2 over DDS, as ROS 2's own middleware names and describes them; bytes of messages
// go in and out as they are. By Cyclone DDS.

namespace loopstone::app {

/// By this machine's clock.
[[nodiscard]] Stamp now();

/// How a topic is told, in the words of DDS: RELIABILITY, DURABILITY, HISTORY.
struct TopicQuality {
  bool is_reliable = false;  ///< else best effort; a reader that is gets nothing of one that isn't
  bool is_latched = false;   ///< transient local: who comes late gets the last ones
  int depth = 10;            ///< messages kept
};

struct RosTopic {
  std::string name{};       ///< "/scan"
  std::string type{};       ///< "sensor_msgs/LaserScan"
  std::string type_hash{};  ///< RIHS01, which other programs of ROS 2 may ask for
  TopicQuality quality{};
};

template <typename M>
[[nodiscard]] RosTopic ros_topic(std::string name, const TopicQuality& quality) {
  return {std::move(name), MessageType<M>::name(), MessageType<M>::rihs01(), quality};
}

struct DdsOptions {
  std::uint32_t domain = 0;  ///< ROS_DOMAIN_ID
  std::string interface {};  ///< of the network; empty: Cyclone chooses
};

/// What Cyclone has to say, each kind once: without its network it says the same again and again.
class CycloneNews {
 public:
  explicit CycloneNews(std::function<void(const std::string&)> tell) : tell_(std::move(tell)) {}
  /// By any thread.
  void add(std::string_view text);

 private:
  std::function<void(const std::string&)> tell_;
  std::mutex mutex_{};
  std::set<std::string, std::less<>> told_{};  ///< without their numbers
};

/// This program among those that speak DDS. What Cyclone has to say is told by `tell`, from any
/// thread; there may be one such object at a time.
class DdsNode {
 public:
  /// Throws UsageError for an interface that has no name, DataError when there is no network.
  DdsNode(const DdsOptions& options, std::function<void(const std::string&)> tell);
  ~DdsNode();
  DdsNode(const DdsNode&) = delete;
  DdsNode& operator=(const DdsNode&) = delete;

 private:
  friend class DdsInbox;
  friend class DdsOutlet;
  /// Of a topic: what is read or written there goes with the node. Throws UsageError for a name
  /// that no topic can have.
  [[nodiscard]] std::int32_t add_topic(const RosTopic& topic) const;

  CycloneNews news_;
  std::int32_t domain_ = 0;
  std::int32_t participant_ = 0;
};

/// What comes on some topics. One thread.
class DdsInbox {
 public:
  /// \param topics  of those that have messages, the first one's come first
  DdsInbox(const DdsNode& node, std::vector<RosTopic> topics);
  ~DdsInbox();
  DdsInbox(const DdsInbox&) = delete;
  DdsInbox& operator=(const DdsInbox&) = delete;

  /// Nothing: none came within the time.
  [[nodiscard]] std::optional<CameMessage> take(std::chrono::milliseconds patience);

 private:
  struct Reader {
    RosTopic topic{};
    std::int32_t reader = 0;
  };
  [[nodiscard]] std::optional<CameMessage> take_now();

  std::vector<Reader> readers_{};
  std::int32_t waitset_ = 0;
};

/// A topic that is told. Any thread.
class DdsOutlet {
 public:
  DdsOutlet(const DdsNode& node, const RosTopic& topic);
  ~DdsOutlet();
  DdsOutlet(const DdsOutlet&) = delete;
  DdsOutlet& operator=(const DdsOutlet&) = delete;

  /// \param bytes  CDR with its encapsulation
  /// Whoever can't be reached, or is too slow, misses it.
  void write(const std::string& bytes) const;
  /// Not for a stamp that no message of ROS 2 holds.
  template <typename M>
  void send(const M& message) const {
    std::string bytes;
    try {
      encode_message(WireFormat::kCdr, message, bytes);
    } catch (const MessageError&) {
      return;
    }
    write(bytes);
  }
  /// Returns when all of those who listen have got it, or after so long.
  void wait_for_readers(std::chrono::milliseconds patience) const;

 private:
  std::int32_t writer_ = 0;
};

}  // namespace loopstone::app
