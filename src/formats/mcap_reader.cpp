#include <libdeflate.h>

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "formats/chunk_index.hpp"
#include "formats/chunk_unpack.hpp"
#include "formats/mcap_record.hpp"
#include "formats/recorded_topics.hpp"
#include "formats/recording.hpp"
#include "formats/recording_bytes.hpp"

namespace loopstone {
namespace {

/// What is looked through at once for the next record behind damage.
constexpr std::uint64_t kSearchBytes = std::uint64_t{1} << 22;
constexpr std::uint64_t kFooterLength = 20;

/// A schema that channels may still refer to.
struct KnownSchema {
  std::string type{};
  MessageDefinition definition{};
};

/// A chunk in the file: what is needed of it once its bytes are no longer held.
struct McapChunkPlace {
  std::optional<Packing> packing{};
  std::uint64_t unpacked_size = 0;
  std::uint32_t checksum = 0;
  std::uint64_t at = 0;
  std::uint64_t data = 0;    ///< where what is packed begins
  std::uint64_t stored = 0;  ///< bytes of it that are there
  std::uint64_t end = 0;     ///< where the next record is
  bool fits = false;         ///< its record has the place that it says
  bool is_cut = false;
};

DefinitionLanguage language_of(std::string_view encoding) {
  if (encoding == "ros1msg") return DefinitionLanguage::kRos1Msg;
  if (encoding == "ros2msg") return DefinitionLanguage::kRos2Msg;
  if (encoding == "ros2idl") return DefinitionLanguage::kRos2Idl;
  return DefinitionLanguage::kNone;
}

class McapReader final : public Recording {
 public:
  McapReader(std::unique_ptr<RecordingBytes> bytes, const RecordingOptions& options)
      : bytes_(std::move(bytes)),
        memory_(options.memory),
        topics_(options.memory, bytes_->size(), bytes_->name()),
        damage_(options.on_damage, bytes_->name()),
        channels_(std::size_t{1} << 16U, kNone) {
    require_magic();
    data_end_ = bytes_->size();
    load_summary();
    first_channels_ = channels_;
    first_schemas_ = schemas_;
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
    const std::uint64_t done = at_ >= data_end_ ? bytes_->size() : at_;
    return {static_cast<std::int64_t>(done), static_cast<std::int64_t>(bytes_->size())};
  }
  std::vector<std::string> notes() const override;

 private:
  static constexpr std::int32_t kNone = -1;

  void require_magic();
  void begin();

  void load_summary();
  bool has_right_checksum(std::uint64_t begin, std::uint64_t footer, std::uint32_t checksum);
  template <typename Use>
  bool for_each_in_summary(std::uint64_t begin, std::uint64_t end, Use&& use);
  bool has_schemas_of_channels(std::uint64_t begin, std::uint64_t end);
  bool index_chunk(std::string_view fields, std::uint64_t summary_at);
  bool count_messages(std::string_view fields);
  bool knows_indexed_channels() const;

  std::optional<McapRecord> head(std::uint64_t at);
  bool is_chunk(std::uint64_t at);
  bool ends_well(std::uint64_t end);
  std::uint64_t end_before_next_chunk(std::uint64_t at, std::uint64_t end);
  std::optional<std::uint64_t> find_chunk_from(std::uint64_t at);

  std::optional<RecordedMessage> step();
  void pass_damage(const std::string& reason);
  void go_on_from(std::uint64_t place);
  std::optional<std::uint64_t> search(std::uint64_t from, std::uint64_t limit);
  std::optional<RecordedMessage> use_record(McapOp op, std::string_view fields,
                                            const MessagePlace& place);
  std::string_view record_at(const MessagePlace& place);

  bool may_be_skipped(std::uint64_t at) const;
  std::optional<McapChunkPlace> chunk_place(std::uint64_t at);
  UnpackedChunk unpack(ChunkUnpacker& unpacker, const McapChunkPlace& chunk);
  void open_chunk();
  std::uint64_t end_of_chunk(std::uint64_t end, std::uint64_t data_end);
  void tell_wrong_chunk(const UnpackedChunk& unpacked, const McapChunkPlace& chunk);
  std::optional<RecordedMessage> next_in_chunk();
  bool pass_damage_in_chunk();

  bool add_schema(std::string_view fields);
  bool add_channel(std::string_view fields);

  std::unique_ptr<RecordingBytes> bytes_;
  MemoryBudget memory_;
  RecordedTopics topics_;
  ToldDamage damage_;
  ChunkUnpacker unpacker_{};
  const std::function<void()> stop_ = [this] { bytes_->ask_stop(); };
  const std::function<bool(std::uint16_t)> knows_channel_ = [this](std::uint16_t channel) {
    return channels_[channel] != kNone;
  };

  std::vector<std::int32_t> channels_;  ///< to topics
  std::unordered_map<std::uint16_t, KnownSchema> schemas_{};
  std::vector<std::int32_t> first_channels_{};  ///< of the summary
  std::unordered_map<std::uint16_t, KnownSchema> first_schemas_{};
  ChunkIndex index_{};
  bool is_indexed_ = false;
  bool was_closed_ = false;
  bool has_damaged_summary_ = false;
  bool has_all_channels_ = true;  ///< in the summary, as far as it says how many there are
  std::uint64_t data_end_ = 0;    ///< of the records that hold messages

  std::uint64_t at_ = 0;      ///< of the next record
  std::uint64_t resume_ = 0;  ///< from where on to search when there is none

  bool in_chunk_ = false;
  bool told_chunk_ = false;  ///< that it is damaged
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

void McapReader::require_magic() {
  const std::string_view head = bytes_->view(0, kMcapMagic.size());
  if (head == kMcapMagic) return;
  if (head.starts_with("\x89MCAP")) {
    throw DataError({bytes_->name()}, "is an MCAP file of another version than 0");
  }
  throw DataError({bytes_->name()}, "is no MCAP file");
}

void McapReader::begin() {
  at_ = resume_ = kMcapMagic.size();
  in_chunk_ = false;
  if (is_indexed_) return;
  channels_ = first_channels_;
  schemas_ = first_schemas_;
}

std::vector<std::string> McapReader::notes() const {
  if (is_indexed_) return {};
  if (has_damaged_summary_) return {"its index is damaged"};
  if (was_closed_) return {"has no index"};
  return {"has no index: it was not closed properly"};
}

// The summary.

void McapReader::load_summary() {
  constexpr std::uint64_t kTail = kMcapHead + kFooterLength + kMcapMagic.size();
  if (bytes_->size() < kMcapMagic.size() + kTail) return;
  const std::uint64_t footer = bytes_->size() - kTail;
  const std::string_view tail = bytes_->view(footer, kTail);
  const auto record = read_mcap_head(tail);
  if (!tail.ends_with(kMcapMagic) || !record || record->op != McapOp::kFooter ||
      record->length != kFooterLength) {
    return;
  }
  McapFields in(tail.substr(kMcapHead));
  const auto begin = in.number<std::uint64_t>();
  (void)in.number<std::uint64_t>();  // of the offsets in the summary
  const auto checksum = in.number<std::uint32_t>();
  was_closed_ = true;
  data_end_ = footer;
  if (begin == 0) return;
  has_damaged_summary_ = true;
  if (begin < kMcapMagic.size() || begin >= footer) return;
  if (!has_right_checksum(begin, footer, checksum)) return;
  const auto pass = [](McapOp, std::string_view) { return true; };
  if (!for_each_in_summary(begin, footer, pass)) return;
  bool has_statistics = false;
  bool good = for_each_in_summary(begin, footer, [&](McapOp op, std::string_view fields) {
    return op != McapOp::kSchema || add_schema(fields);
  });
  if (good && !has_schemas_of_channels(begin, footer)) {
    has_damaged_summary_ = false;
    return;
  }
  good = good && for_each_in_summary(begin, footer, [&](McapOp op, std::string_view fields) {
           has_statistics = has_statistics || op == McapOp::kStatistics;
           if (op == McapOp::kChannel) return add_channel(fields);
           return op != McapOp::kChunkIndex || index_chunk(fields, begin);
         });
  good = good && for_each_in_summary(begin, footer, [&](McapOp op, std::string_view fields) {
           return op != McapOp::kStatistics || count_messages(fields);
         });
  has_damaged_summary_ = !good;
  is_indexed_ = good && has_all_channels_ && (has_statistics || index_.size() > 0) &&
                knows_indexed_channels();
  index_.sort();
  if (!good) index_.clear();
  if (is_indexed_) data_end_ = begin;
}

bool McapReader::has_right_checksum(std::uint64_t begin, std::uint64_t footer,
                                    std::uint32_t checksum) {
  if (checksum == 0) return true;
  constexpr std::uint64_t kBlock = std::uint64_t{1} << 20;
  const std::uint64_t end = footer + kMcapHead + 16;  // all of the footer before the checksum
  std::uint32_t found = 0;
  for (std::uint64_t at = begin; at < end;) {
    const std::string_view block = bytes_->view(at, std::min(kBlock, end - at));
    if (block.empty()) return false;
    found = libdeflate_crc32(found, block.data(), block.size());
    at += block.size();
  }
  return found == checksum;
}

/// False when a record is damaged or `use` says so.
template <typename Use>
bool McapReader::for_each_in_summary(std::uint64_t begin, std::uint64_t end, Use&& use) {
  std::uint64_t at = begin;
  while (at < end) {
    const auto record = head(at);
    if (!record || record->end() > end - at) return false;
    const std::string_view fields = bytes_->view(at + kMcapHead, record->length);
    if (fields.size() < record->length || !use(record->op, fields)) return false;
    at += record->end();
  }
  return true;
}

/// Whether the summary repeats the schemas of its channels, which it need not do.
bool McapReader::has_schemas_of_channels(std::uint64_t begin, std::uint64_t end) {
  return for_each_in_summary(begin, end, [this](McapOp op, std::string_view fields) {
    const auto channel = op == McapOp::kChannel ? read_mcap_channel(fields) : std::nullopt;
    return !channel || channel->schema == 0 || schemas_.contains(channel->schema);
  });
}

bool McapReader::index_chunk(std::string_view fields, std::uint64_t summary_at) {
  McapFields in(fields);
  (void)in.take(16);  // the times of its messages
  const auto at = in.number<std::uint64_t>();
  (void)in.number<std::uint64_t>();  // its length
  McapFields offsets(in.text());
  if (!in.is_good() || at >= summary_at) return false;
  topics_.hold(sizeof(ChunkIndex::Chunk) + offsets.left().size());
  index_.add(at);
  while (!offsets.left().empty()) {
    index_.add_channel(offsets.number<std::uint16_t>());
    (void)offsets.number<std::uint64_t>();
    if (!offsets.is_good()) return false;
  }
  return true;
}

bool McapReader::count_messages(std::string_view fields) {
  McapFields in(fields);
  (void)in.number<std::uint64_t>();  // messages
  (void)in.number<std::uint16_t>();  // schemas
  const auto channels = in.number<std::uint32_t>();
  (void)in.take(12 + 16);  // attachments, metadata, chunks; first and last time
  McapFields counts(in.text());
  if (!in.is_good()) return false;
  const auto known = static_cast<std::uint64_t>(
      channels_.size() -
      static_cast<std::size_t>(std::count(channels_.begin(), channels_.end(), kNone)));
  has_all_channels_ = known >= channels;
  while (!counts.left().empty()) {
    const std::int32_t topic = channels_[counts.number<std::uint16_t>()];
    const auto messages = counts.number<std::uint64_t>();
    if (!counts.is_good()) return false;
    if (topic != kNone && messages < (std::uint64_t{1} << 48U)) {
      topics_.count(static_cast<std::size_t>(topic), static_cast<std::int64_t>(messages));
    }
  }
  return true;
}

bool McapReader::knows_indexed_channels() const {
  return std::all_of(index_.channels().begin(), index_.channels().end(),
                     [this](std::uint32_t channel) { return channels_[channel] != kNone; });
}

// Topics.

bool McapReader::add_schema(std::string_view fields) {
  const auto schema = read_mcap_schema(fields);
  if (!schema) return false;
  const auto known = schemas_.find(schema->id);
  if (known != schemas_.end() && is_indexed_) return true;
  KnownSchema fresh{canonical_type(schema->name),
                    {language_of(schema->encoding), std::string(schema->text)}};
  if (known == schemas_.end()) {
    topics_.hold(sizeof fresh + fresh.type.size() + fresh.definition.text.size());
    schemas_.emplace(schema->id, std::move(fresh));
  } else if (known->second.type != fresh.type ||
             known->second.definition.text != fresh.definition.text ||
             known->second.definition.language != fresh.definition.language) {
    topics_.hold(fresh.type.size() + fresh.definition.text.size());
    known->second = std::move(fresh);
  }
  return true;
}

bool McapReader::add_channel(std::string_view fields) {
  const auto channel = read_mcap_channel(fields);
  if (!channel) return false;
  if (channels_[channel->id] != kNone && is_indexed_) return true;
  RecordedTopic topic;
  topic.name = channel->topic;
  if (channel->encoding == "ros1") topic.format = WireFormat::kRos1;
  if (channel->encoding.empty()) {
    topic.unreadable = "in an encoding that the recording does not name";
  } else if (channel->encoding != "ros1" && channel->encoding != "cdr") {
    topic.unreadable = "encoded as " + std::string(channel->encoding.substr(0, 40));
  }
  const auto schema = schemas_.find(channel->schema);
  if (channel->schema != 0 && schema != schemas_.end()) {
    topic.type = schema->second.type;
    topic.definition = schema->second.definition;
  }
  topic.hash = mcap_map_value(channel->metadata, "topic_type_hash");
  if (topic.hash.empty()) topic.hash = mcap_map_value(channel->metadata, "md5sum");
  channels_[channel->id] = static_cast<std::int32_t>(topics_.add(std::move(topic)));
  return true;
}

// Between the chunks.

std::optional<McapRecord> McapReader::head(std::uint64_t at) {
  return read_mcap_head(bytes_->view(at, kMcapHead));
}

bool McapReader::is_chunk(std::uint64_t at) {
  const auto record = head(at);
  return record && record->op == McapOp::kChunk &&
         read_mcap_chunk(bytes_->view(at + kMcapHead, kMostMcapChunkHead)).has_value();
}

bool McapReader::ends_well(std::uint64_t end) {
  if (end == data_end_) return true;
  const auto record = head(end);
  return record && static_cast<int>(record->op) <= static_cast<int>(McapOp::kDataEnd) &&
         record->end() <= bytes_->size() - end;
}

/// Where a record ends that says that it ends at `end`: before the next chunk, if the index knows
/// of one that is really there.
std::uint64_t McapReader::end_before_next_chunk(std::uint64_t at, std::uint64_t end) {
  return index_.first_in(at + 1, end, [this](std::uint64_t chunk) { return is_chunk(chunk); })
      .value_or(end);
}

std::optional<std::uint64_t> McapReader::find_chunk_from(std::uint64_t at) {
  constexpr std::uint64_t kAnywhere = std::numeric_limits<std::uint64_t>::max();
  return index_.first_in(at, kAnywhere, [this](std::uint64_t chunk) { return is_chunk(chunk); });
}

std::optional<RecordedMessage> McapReader::next() {
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

std::optional<RecordedMessage> McapReader::step() {
  const auto record = head(at_);
  if (!record) {
    pass_damage("there should be a record here, and is none");
    return std::nullopt;
  }
  if (record->op == McapOp::kChunk) {
    open_chunk();
    return std::nullopt;
  }
  const std::uint64_t at = at_;
  const std::uint64_t left = data_end_ - at;
  if (record->end() > left && end_before_next_chunk(at, data_end_) == data_end_) {
    if (bytes_->view(at, kMcapMagic.size()) == kMcapMagic) {  // one file behind another
      at_ = resume_ = at + kMcapMagic.size();
      return std::nullopt;
    }
    pass_damage("a record ends behind the end of the file");
    return std::nullopt;
  }
  const std::uint64_t stated_end = at + std::min(record->end(), left + 1);
  const std::uint64_t end = end_before_next_chunk(at, stated_end);
  if (end < stated_end) {
    damage_.tell(at, "a record is longer than the place that it has");
    go_on_from(std::min(at + kMcapHead, end));
    return std::nullopt;
  }
  if (end < data_end_ && !may_follow(record->op, head(end))) {
    pass_damage("there should be a record here, and is none");
    return std::nullopt;
  }
  resume_ = at + kMcapHead;
  at_ = end;
  if (record->op != McapOp::kSchema && record->op != McapOp::kChannel &&
      record->op != McapOp::kMessage) {
    return std::nullopt;
  }
  return use_record(record->op, bytes_->view(at + kMcapHead, record->length),
                    {.at = static_cast<std::int64_t>(at)});
}

/// What stands at at_ is no record. Goes on where the next one is found, at the next chunk that the
/// index knows of at the latest.
void McapReader::pass_damage(const std::string& reason) {
  damage_.tell(at_, reason);
  go_on_from(resume_);
}

void McapReader::go_on_from(std::uint64_t place) {
  const std::uint64_t limit = find_chunk_from(place).value_or(data_end_);
  at_ = resume_ = search(place, limit).value_or(limit);
}

std::optional<std::uint64_t> McapReader::search(std::uint64_t from, std::uint64_t limit) {
  for (std::uint64_t at = from; at < limit; at += kSearchBytes / 2) {
    const std::string_view bytes = bytes_->view(at, std::min(kSearchBytes, limit - at));
    const bool last = at + bytes.size() >= limit;
    if (const auto found = find_mcap_record(bytes, 0, last, knows_channel_)) return at + *found;
    if (last || bytes.empty()) break;
  }
  return std::nullopt;
}

std::optional<RecordedMessage> McapReader::use_record(McapOp op, std::string_view fields,
                                                      const MessagePlace& place) {
  const auto at = static_cast<std::uint64_t>(place.at);
  if (op == McapOp::kMessage) {
    const auto message = read_mcap_message(fields);
    const std::int32_t topic = message ? channels_[message->channel] : kNone;
    if (topic == kNone) {
      damage_.tell(at, "a message of a topic that nothing describes");
      return std::nullopt;
    }
    const auto number = static_cast<std::size_t>(topic);
    if (!topics_.is_wanted(number)) return std::nullopt;
    RecordedMessage given{.topic = number,
                          .recorded = message->recorded,
                          .bytes = {message->bytes.data(), message->bytes.size()},
                          .file = &bytes_->name(),
                          .offset = place.at,
                          .place = place};
    given.place.recorded = message->recorded;
    given.place.size = message->bytes.size();
    return given;
  }
  const bool good = op == McapOp::kSchema    ? add_schema(fields)
                    : op == McapOp::kChannel ? add_channel(fields)
                                             : true;
  if (!good) damage_.tell(at, "what describes a topic is damaged");
  return std::nullopt;
}

// In a chunk.

bool McapReader::may_be_skipped(std::uint64_t at) const {
  if (!is_indexed_ || topics_.wants_all()) return false;
  const ChunkIndex::Chunk* const chunk = index_.find(at);
  if (chunk == nullptr || chunk->channels == 0) return false;
  const auto first = index_.channels().begin() + static_cast<std::ptrdiff_t>(chunk->first);
  return std::none_of(first, first + static_cast<std::ptrdiff_t>(chunk->channels),
                      [this](std::uint32_t channel) {
                        return topics_.is_wanted(static_cast<std::size_t>(channels_[channel]));
                      });
}

/// The chunk that stands there, before data_end_; nothing when there is none.
std::optional<McapChunkPlace> McapReader::chunk_place(std::uint64_t at) {
  const auto record = head(at);
  if (!record || record->op != McapOp::kChunk) return std::nullopt;
  const auto chunk = read_mcap_chunk(bytes_->view(at + kMcapHead, kMostMcapChunkHead));
  if (!chunk) return std::nullopt;
  McapChunkPlace place{.packing = packing_of(chunk->compression),
                       .unpacked_size = chunk->unpacked_size,
                       .checksum = chunk->checksum,
                       .at = at,
                       .data = at + kMcapHead + chunk->data};
  const std::uint64_t data_size = chunk->data_size;
  const std::uint64_t room = data_end_ > place.data ? data_end_ - place.data : 0;
  const std::uint64_t most = std::max(place.data, at + std::min(record->end(), data_end_ - at));
  const std::uint64_t data_end = place.data + std::min(data_size, room);
  place.end = std::max(place.data, end_before_next_chunk(at, most));
  place.fits = data_size <= room && place.end == at + record->end();
  if (data_end != place.end) place.end = end_of_chunk(place.end, data_end);
  place.stored = std::min(place.end, data_end) - place.data;
  place.is_cut = place.stored < data_size;
  return place;
}

UnpackedChunk McapReader::unpack(ChunkUnpacker& unpacker, const McapChunkPlace& chunk) {
  const std::uint64_t allowed = memory_.allowed_bytes(bytes_->size(), Growth::kNumbers);
  memory_.require(chunk.stored, bytes_->size(), Growth::kNumbers, {bytes_->name()});
  return unpacker.unpack(*chunk.packing, bytes_->view(chunk.data, chunk.stored),
                         chunk.unpacked_size, allowed, stop_);
}

void McapReader::open_chunk() {
  const auto chunk = chunk_place(at_);
  if (!chunk) {
    pass_damage("the head of a chunk is damaged or cut");
    return;
  }
  at_ = resume_ = chunk->end;
  if (chunk->fits && may_be_skipped(chunk->at)) return;
  if (!chunk->packing) {
    damage_.tell(chunk->at, "a chunk is packed in a way that is not known");
    if (!ends_well(chunk->end)) go_on_from(chunk->at + 1);
    return;
  }
  const UnpackedChunk unpacked = unpack(unpacker_, *chunk);
  chunk_ = unpacked.bytes;
  chunk_at_ = chunk->at;
  chunk_data_ = *chunk->packing == Packing::kNone ? chunk->data : 0;
  in_chunk_at_ = in_chunk_resume_ = 0;
  in_chunk_ = true;
  tell_wrong_chunk(unpacked, *chunk);
  if (*chunk->packing == Packing::kNone) return;
  // When it ends before the chunk does, or is damaged, the chunk's length may be wrong.
  const bool is_doubtful = told_chunk_ || chunk->data + unpacked.consumed < chunk->end;
  if (is_doubtful && (chunk->is_cut || !ends_well(chunk->end))) {
    go_on_from(told_chunk_ ? chunk->data : chunk->data + unpacked.consumed);
  }
}

/// Of the two ends of a chunk that does not agree with itself, the one behind which there is a
/// record.
std::uint64_t McapReader::end_of_chunk(std::uint64_t end, std::uint64_t data_end) {
  if (end != data_end_ && ends_well(end)) return end;
  if (data_end != data_end_ && ends_well(data_end)) return data_end;
  return std::min(end, data_end);
}

void McapReader::tell_wrong_chunk(const UnpackedChunk& unpacked, const McapChunkPlace& chunk) {
  std::string damage = unpacked.damage;
  if (damage.empty() && chunk.is_cut) damage = "this chunk ends too early";
  if (damage.empty() && unpacked.bytes.size() != chunk.unpacked_size) {
    damage = "this chunk does not unpack to the length that it states";
  }
  if (damage.empty() && chunk.checksum != 0 &&
      libdeflate_crc32(0, unpacked.bytes.data(), unpacked.bytes.size()) != chunk.checksum) {
    damage = "the checksum of this chunk is wrong";
  }
  told_chunk_ = !damage.empty();
  if (told_chunk_) damage_.tell(chunk_at_, damage);
}

std::optional<RecordedMessage> McapReader::next_in_chunk() {
  while (in_chunk_at_ < chunk_.size()) {
    const std::string_view left = chunk_.substr(in_chunk_at_);
    const auto record = read_mcap_head(left);
    const std::uint64_t at = chunk_data_ != 0 ? chunk_data_ + in_chunk_at_ : chunk_at_;
    if (record && record->op == McapOp::kChunk && chunk_data_ != 0) {
      at_ = resume_ = at;  // the chunk ended before, and did not say so
      in_chunk_ = false;
      return std::nullopt;
    }
    const bool fits = record && record->end() <= left.size();
    if (!fits || (record->end() < left.size() &&
                  !may_follow(record->op, read_mcap_head(left.substr(record->end()))))) {
      if (!pass_damage_in_chunk()) break;
      continue;
    }
    MessagePlace place{.at = static_cast<std::int64_t>(at)};
    if (chunk_data_ == 0) place.in_chunk = static_cast<std::int64_t>(in_chunk_at_);
    in_chunk_resume_ = in_chunk_at_ + kMcapHead;
    in_chunk_at_ += static_cast<std::size_t>(record->end());
    const auto length = static_cast<std::size_t>(record->length);
    if (auto message = use_record(record->op, left.substr(kMcapHead, length), place)) {
      return message;
    }
  }
  in_chunk_ = false;
  if (told_chunk_ && chunk_data_ != 0 && at_ == resume_) resume_ = chunk_data_ + in_chunk_resume_;
  return std::nullopt;
}

/// Goes back to the beginning of the last record, whose length may be wrong. False when nothing
/// more is found in this chunk.
bool McapReader::pass_damage_in_chunk() {
  if (!told_chunk_) damage_.tell(chunk_at_, "a record in this chunk is damaged");
  told_chunk_ = true;
  const auto found = find_mcap_record(chunk_, in_chunk_resume_, true, knows_channel_);
  if (!found) return false;
  in_chunk_at_ = *found;
  in_chunk_resume_ = *found + 1;
  return true;
}

// By place.

std::span<const char> McapReader::bytes_at(const MessagePlace& place) {
  const std::string_view bytes = record_at(place);
  const auto record = read_mcap_head(bytes);
  if (record && record->op == McapOp::kMessage && record->end() <= bytes.size()) {
    const auto length = static_cast<std::size_t>(record->length);
    const auto message = read_mcap_message(bytes.substr(kMcapHead, length));
    if (message && message->recorded == place.recorded && message->bytes.size() == place.size) {
      return {message->bytes.data(), message->bytes.size()};
    }
  }
  throw_message_gone({bytes_->name(), {}, place.at});
}

/// From where the record of a message should begin; nothing when there is no such place.
std::string_view McapReader::record_at(const MessagePlace& place) {
  const auto at = static_cast<std::uint64_t>(place.at);
  if (place.in_chunk == MessagePlace::kNoChunk) {
    const auto record = head(at);
    const bool fits = record && record->end() <= bytes_->size() - at;
    return fits ? bytes_->view(at, record->end()) : std::string_view();
  }
  if (placed_at_ != at) {
    placed_at_ = 0;
    const auto chunk = at < data_end_ ? chunk_place(at) : std::nullopt;
    if (!chunk || chunk->packing.value_or(Packing::kNone) == Packing::kNone) return {};
    placed_chunk_ = unpack(placed_unpacker_, *chunk).bytes;
    placed_at_ = at;
  }
  const auto in_chunk = static_cast<std::size_t>(place.in_chunk);
  return in_chunk < placed_chunk_.size() ? placed_chunk_.substr(in_chunk) : std::string_view();
}

}  // namespace

bool is_mcap(std::string_view head) { return head.starts_with("\x89MCAP"); }

std::unique_ptr<Recording> open_mcap(const std::string& path, const RecordingOptions& options) {
  return std::make_unique<McapReader>(std::make_unique<RecordingBytes>(path, options.stop),
                                      options);
}

std::unique_ptr<Recording> read_mcap(std::string_view bytes, const RecordingOptions& options) {
  return std::make_unique<McapReader>(
      std::make_unique<RecordingBytes>(bytes, "bytes in memory", options.stop), options);
}

}  // namespace loopstone
