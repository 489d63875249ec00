#include <algorithm>
#include <unordered_map>
#include <utility>

#include "formats/bag_record.hpp"
#include "formats/chunked_recording.hpp"

namespace loopstone {
namespace {

BagOp op_of(const RecordHead& record) { return static_cast<BagOp>(record.op); }

RecordHead head_of(const BagRecord& record) {
  const BagFields& fields = record.fields;
  RecordHead head{.op = static_cast<std::uint8_t>(fields.op),
                  .head = record.data_at,
                  .data = record.data_at,
                  .end = record.end(),
                  .channel = fields.connection.value_or(0),
                  .recorded = fields.time.value_or(Stamp{})};
  if (fields.op == BagOp::kMessage) head.kind = RecordHead::Kind::kMessage;
  if (fields.op == BagOp::kConnection) head.kind = RecordHead::Kind::kTopic;
  if (fields.op == BagOp::kChunk) head.kind = RecordHead::Kind::kChunk;
  return head;
}

class BagReader final : public ChunkedRecording {
 public:
  BagReader(std::unique_ptr<RecordingBytes> bytes, const RecordingOptions& options)
      : ChunkedRecording(std::move(bytes), options, kBagMagic.size()) {
    require_magic();
    load_index();
    first_connections_ = connections_;
  }

  std::vector<std::string> notes() const override;

 private:
  void require_magic();
  void load_index();
  bool load_index_at(std::uint64_t at, const BagFields& header);
  bool index_chunk(std::string_view bytes, std::uint64_t index_at,
                   std::unordered_map<std::uint32_t, std::int64_t>& counts);

  std::optional<BagRecord> head(std::uint64_t at);
  std::optional<RecordHead> read_record(std::string_view bytes) const override {
    const auto record = read_bag_record(bytes);
    return record ? std::optional(head_of(*record)) : std::nullopt;
  }
  std::optional<RecordHead> record_at(std::uint64_t at) override {
    const auto record = head(at);
    return record ? std::optional(head_of(*record)) : std::nullopt;
  }
  bool ends_well(std::uint64_t end) override {
    return end == data_end_ || record_at(end).has_value();
  }
  std::optional<std::size_t> find_record(std::string_view bytes, std::size_t from,
                                         bool last) const override {
    return find_bag_record(bytes, from, last);
  }
  bool is_chunk(std::uint64_t at) override {
    const auto record = record_at(at);
    return record && record->kind == RecordHead::Kind::kChunk;
  }
  std::optional<ChunkHead> chunk_at(std::uint64_t at) override;
  std::string fault_of(const ChunkHead& chunk, std::string_view unpacked) const override;
  std::optional<std::size_t> topic_of(std::uint32_t connection) const override {
    const auto topic = connections_.find(connection);
    return topic == connections_.end() ? std::nullopt : std::optional(topic->second);
  }
  bool describe(const RecordHead& record, std::string_view bytes) override;

  void begin() override;
  std::optional<RecordedMessage> step() override;
  void pass_damage(const std::string& reason) override;
  void go_on_from(std::uint64_t place) override;

  std::unordered_map<std::uint32_t, std::size_t> connections_{};        ///< to topics
  std::unordered_map<std::uint32_t, std::size_t> first_connections_{};  ///< of the index
  bool names_index_ = false;  ///< the bag's header says where it is
  bool has_wrong_index_records_ = false;
  bool has_junk_ = false;
  bool after_index_record_ = false;
};

void BagReader::require_magic() {
  const std::string_view head = bytes_->view(0, kBagMagic.size());
  if (head == kBagMagic) return;
  if (head.starts_with("#ROSBAG V1.")) {
    throw DataError({bytes_->name()},
                    "is a ROS bag of version 1, from before 2010; convert it with rosbag fix");
  }
  if (head.starts_with("#ROSBAG")) {
    throw DataError({bytes_->name()}, "is a ROS bag of another version than 2.0");
  }
  throw DataError({bytes_->name()}, "is no ROS bag");
}

void BagReader::begin() {
  ChunkedRecording::begin();
  after_index_record_ = false;
  if (!is_indexed_) connections_ = first_connections_;
}

std::optional<BagRecord> BagReader::head(std::uint64_t at) {
  const std::string_view front = bytes_->view(at, 4);
  if (front.size() < 4) return std::nullopt;
  const auto length = little_endian<std::uint32_t>(front.data());
  if (length > kMostBagHeader) return std::nullopt;
  return read_bag_record(bytes_->view(at, std::uint64_t{length} + 8));
}

void BagReader::load_index() {
  const auto record = head(at_);
  if (!record || record->fields.op != BagOp::kBagHeader) return;
  const BagFields header = record->fields;  // the words in it are of no use after the next view
  if (header.is_encrypted) throw DataError({bytes_->name()}, "is an encrypted ROS bag");
  names_index_ = header.index_at != 0;
  if (header.index_at <= at_ || header.index_at > bytes_->size()) return;
  is_indexed_ = load_index_at(header.index_at, header);
  if (is_indexed_) {
    index_.sort();
    data_end_ = header.index_at;
  } else {
    index_.clear();
  }
}

bool BagReader::load_index_at(std::uint64_t at, const BagFields& header) {
  std::uint32_t connections = 0;
  std::unordered_map<std::uint32_t, std::int64_t> counts;
  while (at < bytes_->size()) {
    const auto record = record_at(at);
    if (!record || record->end > bytes_->size() - at) break;
    const std::string_view bytes = bytes_->view(at, record->end);
    if (op_of(*record) == BagOp::kConnection) {
      if (!describe(*record, bytes)) break;
      ++connections;
    } else if (op_of(*record) == BagOp::kChunkInfo) {
      if (!index_chunk(bytes, header.index_at, counts)) break;
    } else {
      break;
    }
    at += record->end;
  }
  for (const auto& [connection, messages] : counts) {
    const auto topic = connections_.find(connection);
    if (topic != connections_.end()) topics_.count(topic->second, messages);
  }
  return connections == header.connections && index_.size() == header.chunks;
}

bool BagReader::index_chunk(std::string_view bytes, std::uint64_t index_at,
                            std::unordered_map<std::uint32_t, std::int64_t>& counts) {
  constexpr std::size_t kEntry = 8;
  const auto record = read_bag_record(bytes);
  if (!record || record->fields.chunk_at >= index_at) return false;
  if (record->data_size != record->fields.count * kEntry) return false;
  topics_.hold(sizeof(ChunkIndex::Chunk) + record->data_size);
  index_.add(record->fields.chunk_at);
  const char* entry = bytes.data() + record->data_at;
  for (std::uint32_t i = 0; i < record->fields.count; ++i, entry += kEntry) {
    const auto connection = little_endian<std::uint32_t>(entry);
    index_.add_channel(connection);
    counts[connection] += little_endian<std::uint32_t>(entry + 4);
  }
  return true;
}

bool BagReader::describe(const RecordHead& /*record*/, std::string_view bytes) {
  const auto record = read_bag_record(bytes);
  if (!record || !record->fields.connection || !record->fields.topic) return false;
  const std::uint32_t id = *record->fields.connection;
  const bool is_new = !connections_.contains(id);
  if (!is_new && is_indexed_) return true;
  RecordedTopic topic;
  topic.name = *record->fields.topic;
  topic.format = WireFormat::kRos1;
  topic.definition.language = DefinitionLanguage::kRos1Msg;
  const auto use = [&](std::string_view name, std::string_view value) {
    if (name == "type") topic.type = canonical_type(value);
    if (name == "md5sum") topic.hash = value;
    if (name == "message_definition") topic.definition.text = value;
  };
  const std::string_view data = bytes.substr(record->data_at);
  if (!for_each_bag_field(data, use) || topic.type.empty()) return false;
  if (is_new) topics_.hold(64);
  connections_[id] = topics_.add(std::move(topic));
  return true;
}

std::vector<std::string> BagReader::notes() const {
  std::vector<std::string> notes;
  if (!is_indexed_ && !names_index_) notes.emplace_back("has no index: it was not closed properly");
  if (!is_indexed_ && names_index_) notes.emplace_back("its index is cut off or damaged");
  if (has_wrong_index_records_) notes.emplace_back("some records of its index have wrong lengths");
  if (has_junk_)
    notes.emplace_back("has bytes of no use before its index, as rosbag reindex leaves");
  return notes;
}

// Between the chunks.

std::optional<RecordedMessage> BagReader::step() {
  const std::uint64_t at = at_;
  const auto record = record_at(at);
  if (!record) {
    pass_damage("there should be a record here, and is none");
    return std::nullopt;
  }
  if (record->kind == RecordHead::Kind::kChunk) {
    after_index_record_ = false;
    open_chunk();
    return std::nullopt;
  }
  const bool is_index_record = op_of(*record) == BagOp::kIndex;
  const std::uint64_t stated_end = at + record->end;
  const std::uint64_t end = end_before_next_chunk(at, stated_end);
  if (end < stated_end) {
    if (is_index_record) {
      has_wrong_index_records_ = true;
    } else {
      damage_.tell(at, "a record is longer than the place that it has");
    }
    go_on_from(std::min(at + record->head, end));
    return std::nullopt;
  }
  if (end > bytes_->size()) {
    pass_damage("a record ends behind the end of the file");
    return std::nullopt;
  }
  resume_ = at + record->head;
  at_ = end;
  after_index_record_ = is_index_record;
  return use_record(*record, at);
}

/// Of a bag with an index not all that is none is damage.
void BagReader::pass_damage(const std::string& reason) {
  const std::uint64_t damaged_at = at_;
  const bool is_a_chunks_place = index_.find(at_) != nullptr;
  const std::size_t known = index_.first_from(at_);
  go_on_from(resume_);
  const bool none_lost = is_indexed_ && !is_a_chunks_place && index_.first_from(at_) == known;
  if (none_lost && at_ == data_end_) {
    has_junk_ = true;
  } else if (none_lost && after_index_record_) {
    has_wrong_index_records_ = true;
  } else {
    damage_.tell(damaged_at, reason);
  }
  after_index_record_ = false;
}

/// Behind the last chunk of an index nothing is searched: there rosbag reindex leaves what it could
/// not use.
void BagReader::go_on_from(std::uint64_t place) {
  if (is_indexed_ && !find_chunk_from(place)) {
    at_ = resume_ = data_end_;
  } else {
    ChunkedRecording::go_on_from(place);
  }
}

std::optional<ChunkHead> BagReader::chunk_at(std::uint64_t at) {
  const auto record = head(at);
  if (!record || record->fields.op != BagOp::kChunk) return std::nullopt;
  ChunkHead chunk{.packing = packing_of(*record->fields.compression),
                  .unpacked_size = record->fields.size,
                  .at = at,
                  .data = at + record->data_at,
                  .stated_size = record->data_size};
  const std::uint64_t stated_end = at + record->end();
  const std::uint64_t most = std::max(chunk.data, std::min(stated_end, data_end_));
  chunk.end = std::max(chunk.data, end_before_next_chunk(at, most));
  chunk.fits = chunk.end == stated_end;
  if (chunk.packing == Packing::kNone) {
    const std::uint64_t other_end = std::min(chunk.data + chunk.unpacked_size, data_end_);
    chunk.end = end_of_chunk(chunk.end, std::max(chunk.data, other_end));
    chunk.stated_size = std::min(chunk.stated_size, chunk.unpacked_size);
  }
  chunk.stored_size = chunk.end - chunk.data;
  return chunk;
}

/// What is packed says itself that it is cut.
std::string BagReader::fault_of(const ChunkHead& chunk, std::string_view /*unpacked*/) const {
  return chunk.packing == Packing::kNone && chunk.is_cut() ? "this chunk ends too early" : "";
}

}  // namespace

bool is_bag(std::string_view head) { return head.starts_with("#ROSBAG V"); }

std::unique_ptr<Recording> open_bag(const std::string& path, const RecordingOptions& options) {
  return std::make_unique<BagReader>(std::make_unique<RecordingBytes>(path, options.stop), options);
}

std::unique_ptr<Recording> read_bag(std::string_view bytes, const RecordingOptions& options) {
  return std::make_unique<BagReader>(
      std::make_unique<RecordingBytes>(bytes, "bytes in memory", options.stop), options);
}

}  // namespace loopstone
