#include <lz4frame.h>

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "formats/atomic_file.hpp"
#include "formats/recording_writer.hpp"
#include "formats/written_bytes.hpp"
#include "formats/written_stamps.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/memory_budget.hpp"

namespace loopstone {
namespace {

constexpr std::string_view kVersionLine = "#ROSBAG V2.0\n";
constexpr std::size_t kChunkBytes = 768 * 1024;  // as rosbag's own writer
constexpr std::size_t kBagHeaderBytes = 4096;
/// Lengths are 32 bits wide; this leaves room for what stands around the bytes.
constexpr std::size_t kMostMessageBytes = std::size_t{1} << 31;

enum class Op : unsigned char {
  kMessage = 2,
  kBagHeader = 3,
  kIndex = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7,
};

std::string u32(std::uint64_t value) {
  std::string bytes;
  append_little_endian(bytes, static_cast<std::uint32_t>(value));
  return bytes;
}

/// Fields "name=value", each behind its length.
class Fields {
 public:
  explicit Fields(Op op) { add("op", std::string(1, static_cast<char>(op))); }
  Fields() = default;
  Fields& add(std::string_view name, std::string_view value) {
    bytes_ += u32(name.size() + 1 + value.size());
    bytes_ += name;
    bytes_ += '=';
    bytes_ += value;
    return *this;
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

void append_part(std::string& bytes, std::string_view part) {
  bytes += u32(part.size());
  bytes += part;
}

std::string record(const Fields& header, std::string_view data) {
  std::string bytes;
  append_part(bytes, header.bytes());
  append_part(bytes, data);
  return bytes;
}

/// A time of ROS 1: seconds and nanoseconds, 32 bits each.
std::string time_of(std::uint64_t time_ns) {
  constexpr std::uint64_t kSecond = 1'000'000'000;
  return u32(time_ns / kSecond) + u32(time_ns % kSecond);
}

struct Connection {
  WrittenTopic topic{};
  bool is_written = false;
  std::string index{};  ///< of the chunk
  std::uint32_t indexed = 0;
};

struct ChunkEntry {
  std::uint64_t offset = 0;
  std::uint64_t first_ns = 0;
  std::uint64_t last_ns = 0;
  std::string counts{};
  std::uint32_t connections = 0;
};

class BagWriter final : public RecordingWriter {
 public:
  explicit BagWriter(const std::string& path) : file_(path) {
    put(kVersionLine);
    put(bag_header(0));  // its numbers come with finish()
  }

  WireFormat wire_format() const override { return WireFormat::kRos1; }

  std::size_t add_topic(const WrittenTopic& topic) override {
    connections_.push_back({.topic = topic});
    return connections_.size() - 1;
  }

  void write(std::size_t topic, Stamp recorded, std::span<const char> bytes) override {
    const std::uint64_t time_ns = written_nanoseconds(recorded, file_.path());
    if (time_ns / 1'000'000'000 > std::numeric_limits<std::uint32_t>::max()) {
      throw DataError({file_.path()}, "a bag of ROS 1 has no place for times after the year 2106");
    }
    if (bytes.size() > kMostMessageBytes) {
      throw DataError({file_.path()},
                      "a bag of ROS 1 has no place for a message of " + bytes_text(bytes.size()));
    }
    Connection& connection = connections_.at(topic);
    if (!connection.is_written) chunk_ += connection_record(topic);
    connection.is_written = true;
    if (is_empty_) first_ns_ = last_ns_ = time_ns;
    first_ns_ = std::min(first_ns_, time_ns);
    last_ns_ = std::max(last_ns_, time_ns);
    is_empty_ = false;
    connection.index += time_of(time_ns) + u32(chunk_.size());
    ++connection.indexed;
    append_part(chunk_,
                Fields(Op::kMessage).add("conn", u32(topic)).add("time", time_of(time_ns)).bytes());
    append_part(chunk_, {bytes.data(), bytes.size()});
    if (chunk_.size() >= kChunkBytes) put_chunk();
  }

  void finish() override {
    put_chunk();
    const std::uint64_t index = offset_;
    for (std::size_t topic = 0; topic < connections_.size(); ++topic) put(connection_record(topic));
    for (const ChunkEntry& chunk : chunks_) {
      put(record(Fields(Op::kChunkInfo)
                     .add("ver", u32(1))
                     .add("chunk_pos", u64(chunk.offset))
                     .add("start_time", time_of(chunk.first_ns))
                     .add("end_time", time_of(chunk.last_ns))
                     .add("count", u32(chunk.connections)),
                 chunk.counts));
    }
    file_.overwrite(kVersionLine.size(), bag_header(index));
    file_.commit();
  }

 private:
  [[nodiscard]] static std::string u64(std::uint64_t value) {
    std::string bytes;
    append_little_endian(bytes, value);
    return bytes;
  }

  void put(std::string_view bytes) {
    file_.write(bytes);
    offset_ += bytes.size();
  }

  [[nodiscard]] std::string bag_header(std::uint64_t index) const {
    Fields fields(Op::kBagHeader);
    fields.add("index_pos", u64(index));
    fields.add("conn_count", u32(index == 0 ? 0 : connections_.size()));
    fields.add("chunk_count", u32(chunks_.size()));
    constexpr std::size_t kLengths = 8;
    return record(fields, std::string(kBagHeaderBytes - kLengths - fields.bytes().size(), ' '));
  }

  [[nodiscard]] std::string connection_record(std::size_t topic) const {
    const WrittenTopic& written = connections_[topic].topic;
    Fields data;
    data.add("topic", written.name);
    data.add("type", written.type);
    data.add("md5sum", written.md5);
    data.add("message_definition", written.ros1_definition);
    if (written.latched) data.add("latching", "1");
    return record(Fields(Op::kConnection).add("conn", u32(topic)).add("topic", written.name),
                  data.bytes());
  }

  /// A frame as rosbag's reader insists on: independent blocks, a checksum of the whole, neither
  /// its size nor checksums of blocks.
  void pack() {
    LZ4F_preferences_t preferences{};
    preferences.frameInfo.blockSizeID = LZ4F_max256KB;
    preferences.frameInfo.blockMode = LZ4F_blockIndependent;
    preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
    preferences.frameInfo.blockChecksumFlag = LZ4F_noBlockChecksum;
    packed_.resize(LZ4F_compressFrameBound(chunk_.size(), &preferences));
    const std::size_t size = LZ4F_compressFrame(packed_.data(), packed_.size(), chunk_.data(),
                                                chunk_.size(), &preferences);
    if (LZ4F_isError(size) != 0) throw DataError({file_.path()}, LZ4F_getErrorName(size));
    packed_.resize(size);
  }

  void put_chunk() {
    if (is_empty_) return;
    pack();
    ChunkEntry entry{.offset = offset_, .first_ns = first_ns_, .last_ns = last_ns_};
    std::string head;
    append_part(
        head, Fields(Op::kChunk).add("compression", "lz4").add("size", u32(chunk_.size())).bytes());
    head += u32(packed_.size());
    put(head);
    put(packed_);
    for (std::size_t topic = 0; topic < connections_.size(); ++topic) {
      Connection& connection = connections_[topic];
      if (connection.indexed == 0) continue;
      put(record(Fields(Op::kIndex)
                     .add("ver", u32(1))
                     .add("conn", u32(topic))
                     .add("count", u32(connection.indexed)),
                 connection.index));
      entry.counts += u32(topic) + u32(connection.indexed);
      ++entry.connections;
      connection.index.clear();
      connection.indexed = 0;
    }
    chunks_.push_back(std::move(entry));
    chunk_.clear();
    if (chunk_.capacity() > 4 * kChunkBytes) {  // one huge message
      chunk_.shrink_to_fit();
      packed_ = {};
    }
    is_empty_ = true;
  }

  AtomicFile file_;
  std::uint64_t offset_ = 0;
  std::vector<Connection> connections_;
  std::vector<ChunkEntry> chunks_;
  std::string chunk_;
  std::string packed_;
  bool is_empty_ = true;
  std::uint64_t first_ns_ = 0;
  std::uint64_t last_ns_ = 0;
};

}  // namespace

std::unique_ptr<RecordingWriter> create_bag(const std::string& path) {
  return std::make_unique<BagWriter>(path);
}

}  // namespace loopstone
