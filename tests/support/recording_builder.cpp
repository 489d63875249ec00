#include "support/recording_builder.hpp"

#include <bzlib.h>
#include <lz4.h>
#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <map>
#include <random>
#include <stdexcept>
#include <string_view>

namespace loopstone::test {
namespace {

template <typename T>
std::string number(T value) {
  std::string bytes(sizeof value, '\0');
  for (std::size_t i = 0; i < sizeof value; ++i) {
    bytes[i] = static_cast<char>((static_cast<std::uint64_t>(value) >> (8 * i)) & 0xffU);
  }
  return bytes;
}
std::string u16(std::size_t value) { return number(static_cast<std::uint16_t>(value)); }
std::string u32(std::size_t value) { return number(static_cast<std::uint32_t>(value)); }
std::string u64(std::size_t value) { return number(static_cast<std::uint64_t>(value)); }
std::string text(std::string_view value) { return u32(value.size()) + std::string(value); }

std::size_t topic_number(const std::string& name) {
  const auto& topics = built_topics();
  const auto found = std::find_if(topics.begin(), topics.end(),
                                  [&](const BuiltTopic& topic) { return topic.name == name; });
  return static_cast<std::size_t>(found - topics.begin());
}

std::size_t nanoseconds(Stamp stamp) { return static_cast<std::size_t>(stamp.nanoseconds); }

/// Which topics occur in some of the messages.
std::map<std::size_t, std::size_t> counts_of(const std::vector<BuiltMessage>& messages,
                                             const BuiltRecording::Part& part) {
  std::map<std::size_t, std::size_t> counts;
  for (std::size_t i = 0; i < part.messages; ++i) {
    ++counts[topic_number(messages[part.first + i].topic)];
  }
  return counts;
}

// Bags.

using Fields = std::vector<std::pair<std::string, std::string>>;

std::string fields_text(const Fields& fields) {
  std::string bytes;
  for (const auto& [name, value] : fields) bytes += text(name + "=" + value);
  return bytes;
}
std::string bag_record(Fields fields, char op, bool op_first, std::string_view data) {
  fields.insert(op_first ? fields.begin() : fields.end(), {"op", std::string(1, op)});
  return text(fields_text(fields)) + text(data);
}

class BagBuilder {
 public:
  BagBuilder(const std::vector<BuiltMessage>& messages, const BagBuild& build)
      : messages_(messages), build_(build) {}

  BuiltRecording made() {
    std::string& out = made_.bytes;
    out = "#ROSBAG V2.0\n" + bag_header(0, 0);
    for (std::size_t first = 0, group = 0; first < messages_.size(); ++group) {
      const std::size_t count = std::min(build_.per_chunk, messages_.size() - first);
      if (build_.outside_of_chunks && group % 2 == 1) {
        add_outside(first, count);
      } else {
        add_chunk(first, count);
      }
      first += count;
    }
    out += std::string(build_.junk_before_index, '\x7f');
    if (!build_.is_indexed) return made_;
    const std::size_t index_at = out.size();
    for (std::size_t i = 0; i < built_topics().size(); ++i) out += connection(i);
    out += chunk_infos_;
    const std::string header = bag_header(index_at, chunks_);
    out.replace(13, header.size(), header);
    return made_;
  }

 private:
  std::string record(const Fields& fields, char op, std::string_view data) const {
    return bag_record(fields, op, build_.chunk_op_first, data);
  }
  std::string bag_header(std::size_t index_at, std::size_t chunks) const {
    const std::size_t topics = index_at == 0 ? 0 : built_topics().size();
    return record(
        {{"index_pos", u64(index_at)}, {"conn_count", u32(topics)}, {"chunk_count", u32(chunks)}},
        3, std::string(200, ' '));
  }
  std::string connection(std::size_t i) const {
    const BuiltTopic& topic = built_topics()[i];
    const Fields data{{"topic", topic.name},
                      {"type", topic.type == "tf2_msgs/TFMessage" ? "tf/tfMessage" : topic.type},
                      {"md5sum", "0123"},
                      {"message_definition", topic.definition},
                      {"callerid", "/somebody"},
                      {"latching", "0"}};
    return record({{"topic", topic.name}, {"conn", u32(i)}}, 7, fields_text(data));
  }
  std::string message(std::size_t i) const {
    const BuiltMessage& one = messages_[i];
    const std::size_t seconds = nanoseconds(one.recorded) / 1'000'000'000;
    const std::size_t rest = nanoseconds(one.recorded) % 1'000'000'000;
    return record({{"conn", u32(topic_number(one.topic))}, {"time", u32(seconds) + u32(rest)}}, 2,
                  one.bytes);
  }
  void add_outside(std::size_t first, std::size_t count) {
    for (std::size_t i = first; i < first + count; ++i) {
      const std::size_t begin = made_.bytes.size();
      made_.bytes += connection(topic_number(messages_[i].topic)) + message(i);
      made_.parts.push_back({begin, made_.bytes.size(), i, 1});
    }
  }
  void add_chunk(std::size_t first, std::size_t count) {
    BuiltRecording::Part part{made_.bytes.size(), 0, first, count};
    const auto counts = counts_of(messages_, part);
    std::string inside;
    for (const auto& [topic, number] : counts) inside += connection(topic);
    for (std::size_t i = first; i < first + count; ++i) inside += message(i);
    const char* const word = build_.packing == Packing::kNone    ? "none"
                             : build_.packing == Packing::kBzip2 ? "bz2"
                                                                 : "lz4";
    made_.bytes += record({{"compression", word}, {"size", u32(inside.size())}}, 5,
                          packed(build_.packing, inside));
    part.end = made_.bytes.size();
    made_.parts.push_back(part);
    std::string info;
    for (const auto& [topic, number] : counts) {
      std::string index = record({{"ver", u32(1)}, {"conn", u32(topic)}, {"count", u32(number)}}, 4,
                                 std::string(12 * number, '\x01'));
      if (build_.has_wrong_index_lengths && chunks_ == 0) {
        index.replace(index.size() - 12 * number - 4, 4, u32(12 * number + 5));
      }
      made_.bytes += index;
      info += u32(topic) + u32(number);
    }
    chunk_infos_ += record({{"ver", u32(1)},
                            {"chunk_pos", u64(part.begin)},
                            {"start_time", u64(0)},
                            {"end_time", u64(0)},
                            {"count", u32(counts.size())}},
                           6, info);
    ++chunks_;
  }

  const std::vector<BuiltMessage>& messages_;
  const BagBuild& build_;
  BuiltRecording made_{};
  std::string chunk_infos_{};
  std::size_t chunks_ = 0;
};

// MCAP.

std::uint32_t checksum(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      ::crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

class McapBuilder {
 public:
  McapBuilder(const std::vector<BuiltMessage>& messages, const McapBuild& build)
      : messages_(messages), build_(build) {}

  BuiltRecording made() {
    made_.bytes = "\x89MCAP0\r\n" + record(1, text("ros1") + text("builder"));
    for (std::size_t first = 0, group = 0; first < messages_.size(); ++group) {
      const std::size_t count = std::min(build_.per_chunk, messages_.size() - first);
      if (!build_.has_chunks || (build_.outside_of_chunks && group % 2 == 1)) {
        add_outside(first, count);
      } else {
        add_chunk(first, count);
      }
      first += count;
      if (group == 0 && build_.has_empty_chunk) add_chunk(first, 0);
    }
    if (build_.is_closed) close();
    return made_;
  }

 private:
  std::string record(int op, std::string fields) const {
    if (build_.has_trailing_bytes && op != 2 && op != 5) fields += "later";
    return std::string(1, static_cast<char>(op)) + u64(fields.size()) + fields;
  }
  std::string schema_record(std::size_t i) const {
    const BuiltTopic& topic = built_topics()[i];
    return record(
        3, u16(i + 1) + text(topic.type) + text(build_.schema_encoding) + text(topic.definition));
  }
  std::string channel_record(std::size_t i) const {
    std::string metadata;
    for (const auto& [key, value] : build_.channel_metadata) metadata += text(key) + text(value);
    return record(4, u16(i) + u16(i + 1) + text(built_topics()[i].name) + text(build_.encoding) +
                         text(metadata));
  }
  std::string topic_records(std::size_t i) const { return schema_record(i) + channel_record(i); }
  std::string message(std::size_t i) const {
    const BuiltMessage& one = messages_[i];
    return record(5, u16(topic_number(one.topic)) + u32(i) + u64(nanoseconds(one.recorded)) +
                         u64(nanoseconds(one.recorded)) + one.bytes);
  }
  void add_outside(std::size_t first, std::size_t count) {
    for (std::size_t i = first; i < first + count; ++i) {
      const std::size_t begin = made_.bytes.size();
      made_.bytes += topic_records(topic_number(messages_[i].topic)) + message(i);
      made_.parts.push_back({begin, made_.bytes.size(), i, 1});
      if (build_.has_unknown_records) made_.bytes += record(0x8e, "of somebody else");
    }
  }
  void add_chunk(std::size_t first, std::size_t count) {
    BuiltRecording::Part part{made_.bytes.size(), 0, first, count};
    const auto counts = counts_of(messages_, part);
    std::string inside;
    for (const auto& [topic, number] : counts) inside += topic_records(topic);
    for (std::size_t i = first; i < first + count; ++i) {
      inside += message(i);
      if (build_.has_unknown_records) inside += record(0x7e, "of the future");
    }
    const std::string word = build_.packing == Packing::kLz4    ? "lz4"
                             : build_.packing == Packing::kZstd ? "zstd"
                                                                : "";
    const std::string data =
        inside.empty() ? inside : packed(build_.packing, inside, build_.is_bare_lz4);
    std::uint32_t sum = build_.has_checksums ? checksum(inside) : 0;
    if (build_.has_wrong_checksums) sum ^= 0x55U;
    made_.bytes += record(
        6, u64(0) + u64(1) + u64(inside.size()) + u32(sum) + text(word) + u64(data.size()) + data);
    part.end = made_.bytes.size();
    if (count > 0) made_.parts.push_back(part);
    std::string offsets;
    if (build_.has_message_indexes) {
      for (const auto& [topic, number] : counts) {
        offsets += u16(topic) + u64(made_.bytes.size());
        made_.bytes += record(7, u16(topic) + text(std::string(16 * number, '\x02')));
      }
    }
    chunk_indexes_ += record(8, u64(0) + u64(1) + u64(part.begin) + u64(part.end - part.begin) +
                                    text(offsets) + u64(made_.bytes.size() - part.end) +
                                    text(word) + u64(data.size()) + u64(inside.size()));
    ++chunks_;
  }
  void close() {
    std::string& out = made_.bytes;
    out += record(15, u32(0));
    const std::size_t begin = out.size();
    if (build_.has_summary) {
      if (build_.repeats_channels) {
        for (std::size_t i = 0; i < built_topics().size(); ++i) {
          out += build_.repeats_schemas ? topic_records(i) : channel_record(i);
        }
      }
      if (build_.has_statistics) out += statistics();
      if (build_.has_chunk_indexes) out += chunk_indexes_;
    }
    const std::size_t summary_at = out.size() > begin ? begin : 0;
    const std::string footer = "\x02" + u64(20) + u64(summary_at) + u64(0);
    const std::uint32_t sum = checksum(out.substr(begin) + footer);
    out += footer + u32(build_.has_checksums ? sum : 0) + "\x89MCAP0\r\n";
  }
  std::string statistics() const {
    const auto counts = counts_of(messages_, {0, 0, 0, messages_.size()});
    std::string map;
    for (const auto& [topic, number] : counts) map += u16(topic) + u64(number);
    const std::size_t topics = built_topics().size();
    return record(11, u64(messages_.size()) + u16(topics) + u32(topics) + u32(0) + u32(0) +
                          u32(chunks_) + u64(0) + u64(1) + text(map));
  }

  const std::vector<BuiltMessage>& messages_;
  const McapBuild& build_;
  BuiltRecording made_{};
  std::string chunk_indexes_{};
  std::size_t chunks_ = 0;
};

std::string packed_bzip2(const std::string& bytes) {
  std::string out(bytes.size() + bytes.size() / 50 + 1000, '\0');
  auto size = static_cast<unsigned>(out.size());
  std::string copy = bytes;
  if (BZ2_bzBuffToBuffCompress(out.data(), &size, copy.data(), static_cast<unsigned>(copy.size()),
                               1, 0, 0) != BZ_OK) {
    throw std::runtime_error("bzip2 does not pack");
  }
  out.resize(size);
  return out;
}

}  // namespace

const std::vector<BuiltTopic>& built_topics() {
  static const std::vector<BuiltTopic> topics{
      {"/scan", "sensor_msgs/LaserScan", "Header header\nfloat32[] ranges\n"},
      {"/tf", "tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"},
      {"/camera", "sensor_msgs/Image", "Header header\nuint8[] data\n"}};
  return topics;
}

std::vector<BuiltMessage> some_messages(std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<BuiltMessage> messages;
  for (std::size_t i = 0; i < count; ++i) {
    BuiltMessage message;
    message.topic = built_topics()[random() % built_topics().size()].name;
    message.recorded = {1'600'000'000'000'000'000 + static_cast<std::int64_t>(i) * 25'000'001};
    message.bytes = "message " + std::to_string(i) + " ";
    const std::size_t size = random() % 300;
    for (std::size_t k = 0; k < size; ++k) {
      message.bytes += k % 60 < 30 ? static_cast<char>(random() & 0xffU) : 'a';
    }
    messages.push_back(std::move(message));
  }
  return messages;
}

std::string packed(Packing packing, const std::string& bytes, bool bare_lz4) {
  std::string out;
  if (packing == Packing::kNone) return bytes;
  if (packing == Packing::kBzip2) return packed_bzip2(bytes);
  const auto size = static_cast<int>(bytes.size());
  if (packing == Packing::kZstd) {
    out.resize(ZSTD_compressBound(bytes.size()));
    out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3));
  } else if (bare_lz4) {
    out.resize(static_cast<std::size_t>(LZ4_compressBound(size)));
    out.resize(static_cast<std::size_t>(
        LZ4_compress_default(bytes.data(), out.data(), size, static_cast<int>(out.size()))));
  } else {
    LZ4F_preferences_t how{};
    how.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
    out.resize(LZ4F_compressFrameBound(bytes.size(), &how));
    out.resize(LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), &how));
  }
  return out;
}

BuiltRecording build_bag(const std::vector<BuiltMessage>& messages, const BagBuild& build) {
  return BagBuilder(messages, build).made();
}

BuiltRecording build_mcap(const std::vector<BuiltMessage>& messages, const McapBuild& build) {
  return McapBuilder(messages, build).made();
}

std::vector<BuiltMessage> messages_of(Recording& recording) {
  std::vector<BuiltMessage> messages;
  while (const auto message = recording.next()) {
    messages.push_back({recording.topics()[message->topic].name,
                        message->recorded,
                        {message->bytes.begin(), message->bytes.end()}});
  }
  return messages;
}

}  // namespace loopstone::test
