#include <zstd.h>

#include <algorithm>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "base/crc32.hpp"
#include "formats/atomic_file.hpp"
#include "formats/recording_writer.hpp"
#include "formats/rosbag2_metadata.hpp"
#include "formats/written_bytes.hpp"
#include "formats/written_stamps.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/version.hpp"

namespace loopstone {
namespace {

constexpr std::string_view kMagic = "\x89MCAP0\r\n";
/// As the writers of rosbag2 and MCAP's own do: small enough to be read in time order with little
/// memory and to lose little with one, large enough to be packed well.
constexpr std::size_t kChunkBytes = 768 * 1024;
constexpr int kLevel = 3;

enum class Op : unsigned char {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kMessageIndex = 7,
  kChunkIndex = 8,
  kStatistics = 11,
  kMetadata = 12,
  kMetadataIndex = 13,
  kSummaryOffset = 14,
  kDataEnd = 15,
};

void append_string(std::string& bytes, std::string_view text) {
  append_little_endian(bytes, static_cast<std::uint32_t>(text.size()));
  bytes.append(text);
}

void append_map(std::string& bytes,
                const std::vector<std::pair<std::string, std::string>>& entries) {
  std::string content;
  for (const auto& [key, value] : entries) {
    append_string(content, key);
    append_string(content, value);
  }
  append_string(bytes, content);
}

void append_record(std::string& bytes, Op op, std::string_view content) {
  bytes += static_cast<char>(op);
  append_little_endian(bytes, std::uint64_t{content.size()});
  bytes.append(content);
}

/// What the summary says of a chunk.
struct ChunkEntry {
  std::uint64_t first_ns = 0;
  std::uint64_t last_ns = 0;
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;                                         ///< of the record
  std::vector<std::pair<std::uint16_t, std::uint64_t>> indexes{};  ///< channel, offset
  std::uint64_t index_bytes = 0;
  std::uint64_t packed_bytes = 0;
  std::uint64_t unpacked_bytes = 0;
};

struct Channel {
  WrittenTopic topic{};
  std::uint16_t schema = 0;
  std::uint32_t messages = 0;
  bool is_written = false;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> index{};  ///< of the chunk: time, offset
};

struct Schema {
  std::string content{};
  bool is_written = false;
};

class McapWriter final : public RecordingWriter {
 public:
  explicit McapWriter(const std::string& path) : file_(path), context_(ZSTD_createCCtx()) {
    if (!context_) throw std::bad_alloc();
    put(kMagic);
    std::string header;
    append_string(header, "ros2");
    append_string(header, "loopstone " + std::string(kVersion));
    put_record(Op::kHeader, header);
  }

  WireFormat wire_format() const override { return WireFormat::kCdr; }

  std::size_t add_topic(const WrittenTopic& topic) override {
    constexpr std::size_t kMost = std::numeric_limits<std::uint16_t>::max();
    if (channels_.size() >= kMost)
      throw DataError({file_.path()}, "MCAP has no room for more topics");
    std::string content;
    append_string(content, ros2_type(topic.type));
    append_string(content, "ros2msg");
    append_string(content, topic.ros2_definition);
    const auto [entry, is_new] =
        schema_ids_.emplace(content, static_cast<std::uint16_t>(schemas_.size() + 1));
    if (is_new) schemas_.push_back({content});
    channels_.push_back({.topic = topic, .schema = entry->second});
    return channels_.size() - 1;
  }

  void write(std::size_t topic, Stamp recorded, std::span<const char> bytes) override {
    const std::uint64_t time_ns = written_nanoseconds(recorded, file_.path());
    Channel& channel = channels_.at(topic);
    describe(topic, chunk_);
    if (chunk_messages_ == 0) first_ns_ = last_ns_ = time_ns;
    first_ns_ = std::min(first_ns_, time_ns);
    last_ns_ = std::max(last_ns_, time_ns);
    channel.index.emplace_back(time_ns, chunk_.size());
    constexpr std::size_t kHead = 22;
    chunk_ += static_cast<char>(Op::kMessage);
    append_little_endian(chunk_, std::uint64_t{kHead + bytes.size()});
    append_little_endian(chunk_, id_of(topic));
    append_little_endian(chunk_, channel.messages);
    append_little_endian(chunk_, time_ns);  // when it was recorded
    append_little_endian(chunk_, time_ns);  // when it was sent: the same, for want of better
    chunk_.append(bytes.data(), bytes.size());
    ++channel.messages;
    ++chunk_messages_;
    count(time_ns);
    if (chunk_.size() >= kChunkBytes) put_chunk();
  }

  void finish() override {
    put_chunk();
    // Of topics without messages only this tells.
    for (std::size_t topic = 0; topic < channels_.size(); ++topic) {
      std::string records;
      describe(topic, records);
      put(records);
    }
    const std::uint64_t metadata_offset = offset_;
    const std::string metadata = metadata_content();
    put_record(Op::kMetadata, metadata);
    std::string end;
    append_little_endian(end, crc_);
    put_record(Op::kDataEnd, end);
    put_summary(metadata_offset, offset_);
    put(kMagic);
    file_.commit();
  }

 private:
  [[nodiscard]] static std::uint16_t id_of(std::size_t topic) {
    return static_cast<std::uint16_t>(topic + 1);
  }

  void put(std::string_view bytes) {
    file_.write(bytes);
    crc_ = crc32_of(bytes, crc_);
    offset_ += bytes.size();
  }
  void put_record(Op op, std::string_view content) {
    std::string head;
    head += static_cast<char>(op);
    append_little_endian(head, std::uint64_t{content.size()});
    put(head);
    put(content);
  }

  void count(std::uint64_t time_ns) {
    if (messages_ == 0) all_first_ns_ = all_last_ns_ = time_ns;
    all_first_ns_ = std::min(all_first_ns_, time_ns);
    all_last_ns_ = std::max(all_last_ns_, time_ns);
    ++messages_;
  }

  [[nodiscard]] std::string schema_record(std::size_t schema) const {
    std::string content;
    append_little_endian(content, static_cast<std::uint16_t>(schema + 1));
    content += schemas_[schema].content;
    std::string record;
    append_record(record, Op::kSchema, content);
    return record;
  }

  [[nodiscard]] std::string channel_record(std::size_t topic) const {
    const Channel& channel = channels_[topic];
    std::string content;
    append_little_endian(content, id_of(topic));
    append_little_endian(content, channel.schema);
    append_string(content, channel.topic.name);
    append_string(content, "cdr");
    append_map(content, {{"offered_qos_profiles", format_qos_profiles(channel.topic.latched)},
                         {"topic_type_hash", channel.topic.rihs01}});
    std::string record;
    append_record(record, Op::kChannel, content);
    return record;
  }

  /// Its schema and itself, before its first message.
  void describe(std::size_t topic, std::string& records) {
    Channel& channel = channels_[topic];
    if (channel.is_written) return;
    Schema& schema = schemas_[channel.schema - 1U];
    if (!schema.is_written) records += schema_record(channel.schema - 1U);
    records += channel_record(topic);
    schema.is_written = channel.is_written = true;
  }

  void put_chunk() {
    if (chunk_messages_ == 0) return;  // others can't play an empty one
    packed_.resize(ZSTD_compressBound(chunk_.size()));
    const std::size_t size = ZSTD_compressCCtx(context_.get(), packed_.data(), packed_.size(),
                                               chunk_.data(), chunk_.size(), kLevel);
    if (ZSTD_isError(size) != 0) throw DataError({file_.path()}, ZSTD_getErrorName(size));
    ChunkEntry entry{.first_ns = first_ns_,
                     .last_ns = last_ns_,
                     .offset = offset_,
                     .packed_bytes = size,
                     .unpacked_bytes = chunk_.size()};
    std::string head;
    append_little_endian(head, first_ns_);
    append_little_endian(head, last_ns_);
    append_little_endian(head, std::uint64_t{chunk_.size()});
    append_little_endian(head, crc32_of(chunk_));
    append_string(head, "zstd");
    append_little_endian(head, std::uint64_t{size});
    std::string start;
    start += static_cast<char>(Op::kChunk);
    append_little_endian(start, std::uint64_t{head.size() + size});
    put(start + head);
    put({packed_.data(), size});
    entry.bytes = offset_ - entry.offset;
    put_indexes(entry);
    chunks_.push_back(std::move(entry));
    chunk_.clear();
    if (chunk_.capacity() > 4 * kChunkBytes) {  // one huge message
      chunk_.shrink_to_fit();
      packed_ = {};
    }
    chunk_messages_ = 0;
  }

  void put_indexes(ChunkEntry& entry) {
    const std::uint64_t begin = offset_;
    for (std::size_t topic = 0; topic < channels_.size(); ++topic) {
      auto& index = channels_[topic].index;
      if (index.empty()) continue;
      constexpr std::size_t kEntry = 16;
      entry.indexes.emplace_back(id_of(topic), offset_);
      std::string content;
      append_little_endian(content, id_of(topic));
      append_little_endian(content, static_cast<std::uint32_t>(index.size() * kEntry));
      for (const auto& [time_ns, at] : index) {
        append_little_endian(content, time_ns);
        append_little_endian(content, at);
      }
      put_record(Op::kMessageIndex, content);
      index.clear();
    }
    entry.index_bytes = offset_ - begin;
  }

  /// As rosbag2 leaves it for itself.
  [[nodiscard]] std::string metadata_content() const {
    Rosbag2Contents contents;
    contents.storage = "mcap";
    const auto slash = file_.path().rfind('/');
    contents.file = slash == std::string::npos ? file_.path() : file_.path().substr(slash + 1);
    for (const Channel& channel : channels_) {
      contents.topics.push_back({channel.topic.name, ros2_type(channel.topic.type),
                                 channel.topic.rihs01, channel.topic.latched,
                                 static_cast<std::int64_t>(channel.messages)});
    }
    contents.messages = static_cast<std::int64_t>(messages_);
    contents.first = {static_cast<std::int64_t>(all_first_ns_)};
    contents.last = {static_cast<std::int64_t>(all_last_ns_)};
    std::string content;
    append_string(content, "rosbag2");
    append_map(content, {{"serialized_metadata", format_inner_rosbag2_metadata(contents)}});
    return content;
  }

  [[nodiscard]] std::string statistics_record() const {
    std::string content;
    append_little_endian(content, messages_);
    append_little_endian(content, static_cast<std::uint16_t>(schemas_.size()));
    append_little_endian(content, static_cast<std::uint32_t>(channels_.size()));
    append_little_endian(content, std::uint32_t{0});  // attachments
    append_little_endian(content, std::uint32_t{1});  // metadata
    append_little_endian(content, static_cast<std::uint32_t>(chunks_.size()));
    append_little_endian(content, all_first_ns_);
    append_little_endian(content, all_last_ns_);
    std::string counts;
    for (std::size_t topic = 0; topic < channels_.size(); ++topic) {
      append_little_endian(counts, id_of(topic));
      append_little_endian(counts, std::uint64_t{channels_[topic].messages});
    }
    append_string(content, counts);
    std::string record;
    append_record(record, Op::kStatistics, content);
    return record;
  }

  [[nodiscard]] static std::string chunk_index_record(const ChunkEntry& chunk) {
    std::string content;
    append_little_endian(content, chunk.first_ns);
    append_little_endian(content, chunk.last_ns);
    append_little_endian(content, chunk.offset);
    append_little_endian(content, chunk.bytes);
    std::string indexes;
    for (const auto& [channel, at] : chunk.indexes) {
      append_little_endian(indexes, channel);
      append_little_endian(indexes, at);
    }
    append_string(content, indexes);
    append_little_endian(content, chunk.index_bytes);
    append_string(content, "zstd");
    append_little_endian(content, chunk.packed_bytes);
    append_little_endian(content, chunk.unpacked_bytes);
    std::string record;
    append_record(record, Op::kChunkIndex, content);
    return record;
  }

  /// \param metadata  from there to `end_of_data` less the record of the data's end
  void put_summary(std::uint64_t metadata, std::uint64_t end_of_data) {
    constexpr std::uint64_t kDataEndBytes = 9 + 4;
    const std::uint64_t begin = offset_;
    crc_ = 0;
    std::string offsets;
    std::uint64_t group_begin = offset_;
    const auto end_group = [&](Op op) {
      if (offset_ == group_begin) return;
      std::string content;
      content += static_cast<char>(op);
      append_little_endian(content, group_begin);
      append_little_endian(content, offset_ - group_begin);
      append_record(offsets, Op::kSummaryOffset, content);
      group_begin = offset_;
    };
    for (std::size_t schema = 0; schema < schemas_.size(); ++schema) put(schema_record(schema));
    end_group(Op::kSchema);
    for (std::size_t topic = 0; topic < channels_.size(); ++topic) put(channel_record(topic));
    end_group(Op::kChannel);
    put(statistics_record());
    end_group(Op::kStatistics);
    for (const ChunkEntry& chunk : chunks_) put(chunk_index_record(chunk));
    end_group(Op::kChunkIndex);
    std::string index;
    append_little_endian(index, metadata);
    append_little_endian(index, end_of_data - kDataEndBytes - metadata);
    append_string(index, "rosbag2");
    put_record(Op::kMetadataIndex, index);
    end_group(Op::kMetadataIndex);
    const std::uint64_t offsets_begin = offset_;
    put(offsets);
    std::string footer;
    footer += static_cast<char>(Op::kFooter);
    append_little_endian(footer, std::uint64_t{8 + 8 + 4});
    append_little_endian(footer, begin);
    append_little_endian(footer, offsets_begin);
    put(footer);
    std::string crc;
    append_little_endian(crc, crc_);
    put(crc);
  }

  struct ContextEnd {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  };

  AtomicFile file_;
  std::unique_ptr<ZSTD_CCtx, ContextEnd> context_;
  std::uint32_t crc_ = 0;
  std::uint64_t offset_ = 0;
  std::map<std::string, std::uint16_t> schema_ids_;
  std::vector<Schema> schemas_;
  std::vector<Channel> channels_;
  std::vector<ChunkEntry> chunks_;
  std::string chunk_;
  std::string packed_;
  std::uint64_t chunk_messages_ = 0;
  std::uint64_t first_ns_ = 0;  // of the chunk
  std::uint64_t last_ns_ = 0;
  std::uint64_t messages_ = 0;
  std::uint64_t all_first_ns_ = 0;
  std::uint64_t all_last_ns_ = 0;
};

}  // namespace

std::unique_ptr<RecordingWriter> create_mcap(const std::string& path) {
  return std::make_unique<McapWriter>(path);
}

}  // namespace loopstone
