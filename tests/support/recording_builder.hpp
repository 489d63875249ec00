#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "formats/chunk_unpack.hpp"
#include "formats/recording.hpp"
#include "loopstone/base/stamp.hpp"

// Recordings made in memory, in every way that the containers allow and in some that they don't.

namespace loopstone::test {

struct BuiltMessage {
  std::string topic{};  ///< of built_topics()
  Stamp recorded{};
  std::string bytes{};

  friend bool operator==(const BuiltMessage&, const BuiltMessage&) = default;
};

struct BuiltTopic {
  std::string name{};
  std::string type{};  ///< canonical
  std::string definition{};
};

/// "/scan", "/tf" and "/camera".
[[nodiscard]] const std::vector<BuiltTopic>& built_topics();

/// Messages of all topics, half of their bytes without any order.
[[nodiscard]] std::vector<BuiltMessage> some_messages(std::size_t count, std::uint64_t seed = 1);

struct BuiltRecording {
  /// What holds messages and what describes their topics: a chunk, or one message outside.
  struct Part {
    std::size_t begin = 0;  ///< in the file
    std::size_t end = 0;
    std::size_t first = 0;  ///< of its messages
    std::size_t messages = 0;
  };

  std::string bytes{};
  std::vector<Part> parts{};
};

struct BagBuild {
  Packing packing = Packing::kNone;
  bool is_indexed = true;
  std::size_t per_chunk = 7;
  bool outside_of_chunks = false;        ///< every second group of messages
  bool has_wrong_index_lengths = false;  ///< of the records behind the first chunk
  std::size_t junk_before_index = 0;     ///< bytes
  bool chunk_op_first = true;            ///< the order of fields in headers
};
[[nodiscard]] BuiltRecording build_bag(const std::vector<BuiltMessage>& messages,
                                       const BagBuild& build);

struct McapBuild {
  Packing packing = Packing::kNone;
  bool is_bare_lz4 = false;  ///< blocks of LZ4 without a frame
  std::size_t per_chunk = 7;
  bool has_chunks = true;
  bool outside_of_chunks = false;  ///< every second group of messages
  bool has_message_indexes = true;
  bool has_chunk_indexes = true;
  bool has_summary = true;
  bool repeats_channels = true;  ///< in the summary, with their schemas
  bool repeats_schemas = true;   ///< false: without them
  bool has_statistics = true;
  bool has_checksums = true;
  bool has_wrong_checksums = false;  ///< of chunks
  bool has_unknown_records = false;
  bool has_trailing_bytes = false;  ///< in records, behind what is known of them
  bool has_empty_chunk = false;
  bool is_closed = true;
  std::string encoding = "ros1";
  std::string schema_encoding = "ros1msg";
  std::vector<std::pair<std::string, std::string>> channel_metadata{};
};
[[nodiscard]] BuiltRecording build_mcap(const std::vector<BuiltMessage>& messages,
                                        const McapBuild& build);

/// Packs as chunks are packed.
[[nodiscard]] std::string packed(Packing packing, const std::string& bytes, bool bare_lz4 = false);

/// All messages that a recording gives from where it stands.
[[nodiscard]] std::vector<BuiltMessage> messages_of(Recording& recording);

}  // namespace loopstone::test
