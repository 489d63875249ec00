#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/memory_budget.hpp"
#include "loopstone/base/stamp.hpp"
#include "loopstone/formats/log_format.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/messages/message_codec.hpp"

// Containers of recorded messages (ROS 1 bag, rosbag2's SQLite, MCAP), read as a stream of bytes
// with a topic and a time. What the bytes mean is not a container's to know.

namespace loopstone {

/// A topic as the recording describes it. One topic may stand several times (several publishers,
/// several files, another type later): each has its own entry.
struct RecordedTopic {
  std::string name{};  ///< "/scan"
  std::string type{};  ///< canonical: "sensor_msgs/LaserScan"; as written when it is none of ROS
  WireFormat format = WireFormat::kCdr;
  MessageDefinition definition{};
  std::string hash{};                      ///< MD5 or RIHS01; empty when the recording has none
  std::optional<std::int64_t> messages{};  ///< as an index says: a hint
  /// Why its messages can't be decoded whatever they are ("encoded as protobuf"); empty when they
  /// can.
  std::string unreadable{};
};

/// Where a message is in a recording, to read it again later: Recording::bytes_at(). In the order
/// of places files are read from their beginning to their end.
struct MessagePlace {
  static constexpr std::int64_t kNoChunk = -1;

  std::size_t file = 0;  ///< of the recording, from 0; of one that is a single file 0
  /// Bytes in the file: of the message's record, or of the packed chunk that holds it. Of a
  /// database the message's row.
  std::int64_t at = -1;
  std::int64_t in_chunk = kNoChunk;  ///< bytes of its record in the unpacked chunk
  // By these it is known again.
  Stamp recorded{};
  std::uint64_t size = 0;  ///< bytes, before a message that is packed by itself is unpacked

  friend auto operator<=>(const MessagePlace&, const MessagePlace&) = default;
};

struct RecordedMessage {
  std::size_t topic = 0;          ///< in Recording::topics()
  Stamp recorded{};               ///< when the recorder got it
  std::span<const char> bytes{};  ///< until the next call of the recording
  /// Its name, until the next call of the recording; of a database with the message's row.
  const std::string* file = nullptr;
  std::int64_t offset = -1;  ///< in the file; negative where that would tell nothing
  MessagePlace place{};      ///< also of another Recording of the same file

  /// For errors.
  [[nodiscard]] Location where() const {
    Location location{file != nullptr ? *file : std::string()};
    if (offset >= 0) location.byte_offset = offset;
    return location;
  }
};

struct RecordingOptions {
  MemoryBudget memory{};
  /// Asked before every block: true makes next() throw ReadingStopped. May be empty.
  std::function<bool()> stop{};
  /// Told of damage that was passed: where, and what is wrong. May be empty.
  std::function<void(const Problem&)> on_damage{};
};

/// A container, from its beginning to its end in the order of the file (of SQLite: by time). Damage
/// is told, passed, and everything undamaged behind it is given. Memory is bounded by a chunk (or
/// one message; bytes_at() has a chunk of its own) and what RecordingOptions::memory allows for the
/// file.
class Recording {
 public:
  virtual ~Recording() = default;
  /// Found so far; entries are only added, at the end. Complete from the start when is_indexed().
  [[nodiscard]] virtual const std::vector<RecordedTopic>& topics() const = 0;
  /// Whether an index told of all topics before the first message.
  [[nodiscard]] virtual bool is_indexed() const = 0;
  /// From now on only messages of topics for which this is true are given; chunks that an index
  /// knows to hold none of them are not unpacked. Asked once for each topic. Empty: all.
  virtual void want(std::function<bool(const RecordedTopic&)> wanted) = 0;
  /// Nothing at the end. Throws DataError when nothing more can be read, ReadingStopped.
  [[nodiscard]] virtual std::optional<RecordedMessage> next() = 0;
  /// The bytes of a message that next() of a recording of the same file gave, wanted or not. Until
  /// the next call of the recording, as those of next(), which goes on where it was. A chunk is
  /// unpacked once for all its messages that are asked for one after another, and of the files of a
  /// folder one is kept open: in the order of places that is fastest. Damage of a chunk is not told
  /// again. Throws DataError with the place when the file holds that message no more;
  /// ReadingStopped.
  [[nodiscard]] virtual std::span<const char> bytes_at(const MessagePlace& place) = 0;
  /// Begins again; topics stay known, damage that was told is not told again.
  virtual void rewind() = 0;
  [[nodiscard]] virtual ReadProgress progress() const = 0;
  /// What a user should know beside the damage: "has no index: it was not closed properly".
  [[nodiscard]] virtual std::vector<std::string> notes() const { return {}; }
};

/// What Recording::bytes_at() throws when there is no such message.
[[noreturn]] inline void throw_message_gone(const Location& where) {
  throw DataError(where, "the message that was here is gone: the file was changed meanwhile");
}

/// By the first bytes.
[[nodiscard]] bool is_bag(std::string_view head);
[[nodiscard]] bool is_mcap(std::string_view head);
[[nodiscard]] bool is_sqlite(std::string_view head);

// Throw DataError when there is nothing in the file that can be read. Of a file its index is read,
// if it has one; what is packed as a whole is unpacked.
[[nodiscard]] std::unique_ptr<Recording> open_bag(const std::string& path,
                                                  const RecordingOptions& options);
[[nodiscard]] std::unique_ptr<Recording> open_mcap(const std::string& path,
                                                   const RecordingOptions& options);
/// \param path  of a .db3 (or .db3.zstd), or of a folder of rosbag2 with its splits; the files in
///              the folder may also be MCAP
[[nodiscard]] std::unique_ptr<Recording> open_rosbag2(const std::string& path,
                                                      const RecordingOptions& options);
/// The files that a folder of rosbag2 consists of, in their order; none when it is no such folder.
[[nodiscard]] std::vector<std::string> rosbag2_files(const std::string& folder);

// The same over bytes in memory, which must outlive the recording: for tests and fuzzing.
[[nodiscard]] std::unique_ptr<Recording> read_bag(std::string_view bytes,
                                                  const RecordingOptions& options);
[[nodiscard]] std::unique_ptr<Recording> read_mcap(std::string_view bytes,
                                                   const RecordingOptions& options);
/// A database of rosbag2; it is copied.
[[nodiscard]] std::unique_ptr<Recording> read_sqlite_log(std::string_view bytes,
                                                         const RecordingOptions& options);

}  // namespace loopstone
