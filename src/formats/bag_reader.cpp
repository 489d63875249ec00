#include <algorithm>
#include <unordered_map>
#include <utility>

#include "formats/bag_record.hpp"
#include "formats/chunk_index.hpp"
#include "formats/chunk_unpack.hpp"
#include "formats/recorded_topics.hpp"
#include "formats/recording.hpp"
#include "formats/recording_bytes.hpp"

namespace loopstone {
namespace {

/// What is looked through at once for the next record behind damage.
constexpr std::uint64_t kSearchBytes = std::uint64_t{1} << 22;

/// A record at a place of the file: what is needed of it once its bytes are no longer held.
struct BagPlace {
  BagOp op{};
  std::uint32_t connection = 0;
  Stamp time{};
  std::optional<Packing> packing{};
  std::uint32_t size = 0;
  std::uint64_t at = 0;
  std::uint64_t data = 0;  ///< where its data begins
  std::uint64_t end = 0;   ///< as it says, which may be behind the file's
};

class BagReader final : public Recording {
 public:
  BagReader(std::unique_ptr<RecordingBytes> bytes, const RecordingOptions& options)
      : bytes_(std::move(bytes)),
        memory_(options.memory),
        topics_(options.memory, bytes_->size(), bytes_->name()),
        damage_(options.on_damage, bytes_->name()) {
    require_magic();
    begin();
    load_index();
    first_connections_ = connections_;
    begin();
  }

  const std::vector<RecordedTopic>& topics() const override { return topics_.all(); }
  bool is_indexed() const override { return is_indexed_; }
  void want(std::function<bool(const RecordedTopic&)> wanted) override {
    topics_.want(std::move(wanted));
  }
  std::optional<RecordedMessage> next() override;
  std::span<const char> bytes_at(const MessagePlace& place) override;
  void rewind() override {
    damage_.begin_again();
    begin();
  }
  ReadProgress progress() const override {
    return {static_cast<std::int64_t>(std::min(at_, bytes_->size())),
            static_cast<std::int64_t>(bytes_->size())};
  }
  std::vector<std::string> notes() const override;

 private:
  void require_magic();
  void begin();
  void load_index();
  bool load_index_at(std::uint64_t at, const BagFields& header);
  bool index_chunk(std::string_view bytes, std::uint64_t index_at,
                   std::unordered_map<std::uint32_t, std::int64_t>& counts);

  std::optional<BagRecord> head(std::uint64_t at);
  std::optional<BagPlace> place(std::uint64_t at);
  bool ends_well(std::uint64_t end) { return end == data_end_ || place(end).has_value(); }
  bool is_chunk(std::uint64_t at);
  std::uint64_t end_before_next_chunk(std::uint64_t at, std::uint64_t end);
  std::optional<std::uint64_t> find_chunk_from(std::uint64_t at);

  std::optional<RecordedMessage> step();
  void step_over(const BagPlace& record, std::uint64_t end);
  void pass_damage(const std::string& reason);
  void go_on_from(std::uint64_t place);
  std::optional<std::uint64_t> search(std::uint64_t from, std::uint64_t limit);

  bool may_be_skipped(std::uint64_t at) const;
  void open_chunk(const BagPlace& record);
  std::uint64_t stored_end(const BagPlace& record);
  UnpackedChunk unpack(ChunkUnpacker& unpacker, const BagPlace& record, std::uint64_t end);
  std::uint64_t end_of_chunk(const BagPlace& record, std::uint64_t end, std::uint64_t other_end);
  std::optional<RecordedMessage> next_in_chunk();
  bool pass_damage_in_chunk();
  std::optional<RecordedMessage> give(std::uint32_t connection, Stamp time, std::string_view bytes,
                                      const MessagePlace& place);
  std::string_view record_at(const MessagePlace& place);
  bool add_connection(std::string_view bytes);

  std::unique_ptr<RecordingBytes> bytes_;
  MemoryBudget memory_;
  RecordedTopics topics_;
  ToldDamage damage_;
  ChunkUnpacker unpacker_{};
  const std::function<void()> stop_ = [this] { bytes_->ask_stop(); };

  std::unordered_map<std::uint32_t, std::size_t> connections_{};        ///< to topics
  std::unordered_map<std::uint32_t, std::size_t> first_connections_{};  ///< of the index
  ChunkIndex index_{};
  bool is_indexed_ = false;
  bool names_index_ = false;  ///< the bag's header says where it is
  bool has_wrong_index_records_ = false;
  bool has_junk_ = false;
  std::uint64_t data_end_ = 0;  ///< of the records that hold messages

  std::uint64_t at_ = 0;      ///< of the next record
  std::uint64_t resume_ = 0;  ///< from where on to search when there is none
  bool after_index_record_ = false;

  bool in_chunk_ = false;
  bool cut_chunk_ = false;  ///< that it is damaged was told
  std::string_view chunk_{};
  std::size_t in_chunk_at_ = 0;
  std::size_t in_chunk_resume_ = 0;  ///< from where on to search when there is no record
  std::uint64_t chunk_at_ = 0;       ///< of its record in the file
  std::uint64_t chunk_data_ = 0;     ///< of its bytes in the file, when it is not packed; else 0

  // What was last unpacked for bytes_at().
  ChunkUnpacker placed_unpacker_{};
  std::uint64_t placed_at_ = 0;  ///< 0: nothing
  std::string_view placed_chunk_{};
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
  at_ = resume_ = kBagMagic.size();
  in_chunk_ = after_index_record_ = false;
  if (is_indexed_) return;
  data_end_ = bytes_->size();
  connections_ = first_connections_;
}

std::optional<BagRecord> BagReader::head(std::uint64_t at) {
  const std::string_view front = bytes_->view(at, 4);
  if (front.size() < 4) return std::nullopt;
  const auto length = little_endian<std::uint32_t>(front.data());
  if (length > kMostBagHeader) return std::nullopt;
  return read_bag_record(bytes_->view(at, std::uint64_t{length} + 8));
}

std::optional<BagPlace> BagReader::place(std::uint64_t at) {
  const auto record = head(at);
  if (!record) return std::nullopt;
  const BagFields& fields = record->fields;
  BagPlace place{.op = fields.op,
                 .connection = fields.connection.value_or(0),
                 .time = fields.time.value_or(Stamp{}),
                 .packing = {},
                 .size = fields.size,
                 .at = at,
                 .data = at + record->data_at,
                 .end = at + record->end()};
  if (fields.compression) place.packing = packing_of(*fields.compression);
  return place;
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
    const auto record = place(at);
    if (!record || record->end > bytes_->size()) break;
    if (record->op == BagOp::kConnection) {
      if (!add_connection(bytes_->view(at, record->end - at))) break;
      ++connections;
    } else if (record->op == BagOp::kChunkInfo) {
      if (!index_chunk(bytes_->view(at, record->end - at), header.index_at, counts)) break;
    } else {
      break;
    }
    at = record->end;
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

/// \param bytes  of the whole record
bool BagReader::add_connection(std::string_view bytes) {
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

/// Where a record ends that says that it ends at `end`: before the next chunk, if the index knows
/// of one that is really there.
std::uint64_t BagReader::end_before_next_chunk(std::uint64_t at, std::uint64_t end) {
  return index_.first_in(at + 1, end, [this](std::uint64_t chunk) { return is_chunk(chunk); })
      .value_or(end);
}

std::optional<std::uint64_t> BagReader::find_chunk_from(std::uint64_t at) {
  constexpr std::uint64_t kAnywhere = std::numeric_limits<std::uint64_t>::max();
  return index_.first_in(at, kAnywhere, [this](std::uint64_t chunk) { return is_chunk(chunk); });
}

bool BagReader::is_chunk(std::uint64_t at) {
  const auto record = place(at);
  return record && record->op == BagOp::kChunk;
}

std::optional<RecordedMessage> BagReader::next() {
  if (in_chunk_ && chunk_data_ != 0) chunk_ = bytes_->view(chunk_data_, chunk_.size());
  while (true) {
    if (in_chunk_) {
      if (auto message = next_in_chunk()) return message;
    } else {
      if (at_ >= data_end_) return std::nullopt;
      if (auto message = step()) return message;
    }
  }
}

std::optional<RecordedMessage> BagReader::step() {
  const auto record = place(at_);
  if (!record) {
    pass_damage("there should be a record here, and is none");
    return std::nullopt;
  }
  if (record->op == BagOp::kChunk) {
    open_chunk(*record);
    return std::nullopt;
  }
  const std::uint64_t end = end_before_next_chunk(at_, record->end);
  if (end < record->end) {
    if (record->op == BagOp::kIndex) {
      has_wrong_index_records_ = true;
    } else {
      damage_.tell(at_, "a record is longer than the place that it has");
    }
    go_on_from(std::min(record->data, end));
    return std::nullopt;
  }
  if (end > bytes_->size()) {
    pass_damage("a record ends behind the end of the file");
    return std::nullopt;
  }
  step_over(*record, end);
  if (record->op == BagOp::kConnection) {
    if (!add_connection(bytes_->view(record->at, record->end - record->at))) {
      damage_.tell(record->at, "what describes a topic is damaged");
    }
  }
  if (record->op != BagOp::kMessage) return std::nullopt;
  return give(record->connection, record->time,
              bytes_->view(record->data, record->end - record->data),
              {.at = static_cast<std::int64_t>(record->at)});
}

void BagReader::step_over(const BagPlace& record, std::uint64_t end) {
  resume_ = std::min(record.data, end);
  at_ = end;
  after_index_record_ = record.op == BagOp::kIndex;
}

/// What stands at at_ is no record. Goes on where the next one is found, at the next chunk that the
/// index knows of at the latest.
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
  const auto chunk = find_chunk_from(place);
  const std::uint64_t limit = chunk.value_or(data_end_);
  const bool searches = chunk || !is_indexed_;
  at_ = resume_ = (searches ? search(place, limit) : std::nullopt).value_or(limit);
}

std::optional<std::uint64_t> BagReader::search(std::uint64_t from, std::uint64_t limit) {
  for (std::uint64_t at = from; at < limit; at += kSearchBytes / 2) {
    const std::string_view bytes = bytes_->view(at, std::min(kSearchBytes, limit - at));
    const bool last = at + bytes.size() >= limit;
    if (const auto found = find_bag_record(bytes, 0, last)) return at + *found;
    if (last || bytes.empty()) break;
  }
  return std::nullopt;
}

// In a chunk.

bool BagReader::may_be_skipped(std::uint64_t at) const {
  if (!is_indexed_ || topics_.wants_all()) return false;
  const ChunkIndex::Chunk* const chunk = index_.find(at);
  if (chunk == nullptr || chunk->channels == 0) return false;
  const auto first = index_.channels().begin() + static_cast<std::ptrdiff_t>(chunk->first);
  return std::none_of(first, first + static_cast<std::ptrdiff_t>(chunk->channels),
                      [this](std::uint32_t connection) {
                        const auto topic = connections_.find(connection);
                        return topic == connections_.end() || topics_.is_wanted(topic->second);
                      });
}

/// Where a chunk's bytes end, by its own length and by the index.
std::uint64_t BagReader::stored_end(const BagPlace& record) {
  const std::uint64_t most = std::max(record.data, std::min(record.end, data_end_));
  return std::max(record.data, end_before_next_chunk(record.at, most));
}

UnpackedChunk BagReader::unpack(ChunkUnpacker& unpacker, const BagPlace& record,
                                std::uint64_t end) {
  const std::uint64_t most_bytes = memory_.allowed_bytes(bytes_->size(), Growth::kNumbers);
  memory_.require(end - record.data, bytes_->size(), Growth::kNumbers, {bytes_->name()});
  return unpacker.unpack(*record.packing, bytes_->view(record.data, end - record.data), record.size,
                         most_bytes, stop_);
}

void BagReader::open_chunk(const BagPlace& record) {
  std::uint64_t end = stored_end(record);
  const bool is_cut = end < record.end;
  after_index_record_ = false;
  if (may_be_skipped(record.at) && !is_cut) {
    resume_ = at_ = end;
    return;
  }
  if (record.packing == Packing::kNone) {
    const std::uint64_t other_end = std::min(record.data + record.size, data_end_);
    if (other_end != end) end = end_of_chunk(record, end, other_end);
  }
  if (!record.packing) {
    damage_.tell(record.at, "a chunk is packed in a way that is not known");
    resume_ = at_ = end;
    if (!ends_well(end)) go_on_from(record.at + 1);
    return;
  }
  const UnpackedChunk unpacked = unpack(unpacker_, record, end);
  std::string damage = unpacked.damage;
  if (is_cut && record.packing == Packing::kNone && end < record.data + record.size) {
    damage = "this chunk ends too early";
  }
  if (!damage.empty()) damage_.tell(record.at, damage);
  chunk_ = unpacked.bytes;
  chunk_at_ = record.at;
  chunk_data_ = *record.packing == Packing::kNone ? record.data : 0;
  in_chunk_at_ = in_chunk_resume_ = 0;
  in_chunk_ = true;
  cut_chunk_ = !damage.empty();
  at_ = resume_ = end;
  if (*record.packing == Packing::kNone) return;
  // When it ends before the chunk does, or is damaged, the chunk's length may be wrong.
  const bool is_doubtful = !damage.empty() || record.data + unpacked.consumed < end;
  if (is_doubtful && (is_cut || !ends_well(end))) {
    go_on_from(damage.empty() ? record.data + unpacked.consumed : record.data);
  }
}

/// Of two ends of a chunk that does not agree with itself, the one behind which there is a record.
std::uint64_t BagReader::end_of_chunk(const BagPlace& record, std::uint64_t end,
                                      std::uint64_t other_end) {
  if (end < record.data || other_end < record.data) return std::max(end, record.data);
  if (end != data_end_ && ends_well(end)) return end;
  if (other_end != data_end_ && ends_well(other_end)) return other_end;
  return std::min(end, other_end);
}

std::optional<RecordedMessage> BagReader::next_in_chunk() {
  while (in_chunk_at_ < chunk_.size()) {
    const std::string_view left = chunk_.substr(in_chunk_at_);
    const auto record = read_bag_record(left);
    if (record && record->fields.op == BagOp::kChunk && chunk_data_ != 0) {
      at_ = resume_ = chunk_data_ + in_chunk_at_;  // it ended before, and did not say so
      in_chunk_ = false;
      return std::nullopt;
    }
    if (!record || record->end() > left.size()) {
      if (!pass_damage_in_chunk()) break;
      continue;
    }
    const std::size_t at = in_chunk_at_;
    in_chunk_resume_ = in_chunk_at_ + static_cast<std::size_t>(record->data_at);
    in_chunk_at_ += static_cast<std::size_t>(record->end());
    const BagFields& fields = record->fields;
    if (fields.op == BagOp::kMessage) {
      const std::string_view bytes = left.substr(record->data_at, record->data_size);
      MessagePlace place{.at = static_cast<std::int64_t>(chunk_at_),
                         .in_chunk = static_cast<std::int64_t>(at)};
      if (chunk_data_ != 0) place = {.at = static_cast<std::int64_t>(chunk_data_ + at)};
      if (auto message = give(*fields.connection, *fields.time, bytes, place)) return message;
    } else if (fields.op == BagOp::kConnection) {
      if (!add_connection(left.substr(0, static_cast<std::size_t>(record->end())))) {
        damage_.tell(chunk_at_, "what describes a topic is damaged");
      }
    }
  }
  in_chunk_ = false;
  if (cut_chunk_ && chunk_data_ != 0 && at_ == resume_) resume_ = chunk_data_ + in_chunk_resume_;
  return std::nullopt;
}

/// Goes back to the beginning of the last record, whose length may be wrong. False when nothing
/// more is found in this chunk.
bool BagReader::pass_damage_in_chunk() {
  if (!cut_chunk_) damage_.tell(chunk_at_, "a record in this chunk is damaged");
  cut_chunk_ = true;
  const auto found = find_bag_record(chunk_, in_chunk_resume_, true);
  if (!found) return false;
  in_chunk_at_ = *found;
  in_chunk_resume_ = *found + 1;
  return true;
}

std::optional<RecordedMessage> BagReader::give(std::uint32_t connection, Stamp time,
                                               std::string_view bytes, const MessagePlace& place) {
  const auto topic = connections_.find(connection);
  if (topic == connections_.end()) {
    damage_.tell(static_cast<std::uint64_t>(place.at),
                 "a message of a topic that nothing describes");
    return std::nullopt;
  }
  if (!topics_.is_wanted(topic->second)) return std::nullopt;
  RecordedMessage message{.topic = topic->second,
                          .recorded = time,
                          .bytes = {bytes.data(), bytes.size()},
                          .file = &bytes_->name(),
                          .offset = place.at,
                          .place = place};
  message.place.recorded = time;
  message.place.size = bytes.size();
  return message;
}

// By place.

std::span<const char> BagReader::bytes_at(const MessagePlace& place) {
  const std::string_view bytes = record_at(place);
  const auto record = read_bag_record(bytes);
  if (!record || record->fields.op != BagOp::kMessage || record->end() > bytes.size() ||
      *record->fields.time != place.recorded || record->data_size != place.size) {
    throw_message_gone({bytes_->name(), {}, place.at});
  }
  return {bytes.data() + record->data_at, static_cast<std::size_t>(record->data_size)};
}

/// From where the record of a message should begin; nothing when there is no such place.
std::string_view BagReader::record_at(const MessagePlace& wanted) {
  const auto at = static_cast<std::uint64_t>(wanted.at);
  if (wanted.in_chunk == MessagePlace::kNoChunk) {
    const auto record = place(at);
    const bool fits = record && record->end <= bytes_->size();
    return fits ? bytes_->view(at, record->end - at) : std::string_view();
  }
  if (placed_at_ != at) {
    placed_at_ = 0;
    const auto record = place(at);
    if (!record || record->op != BagOp::kChunk) return {};
    if (record->packing.value_or(Packing::kNone) == Packing::kNone) return {};
    placed_chunk_ = unpack(placed_unpacker_, *record, stored_end(*record)).bytes;
    placed_at_ = at;
  }
  const auto in_chunk = static_cast<std::size_t>(wanted.in_chunk);
  return in_chunk < placed_chunk_.size() ? placed_chunk_.substr(in_chunk) : std::string_view();
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
