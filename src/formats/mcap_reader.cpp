#include <libdeflate.h>

#include <algorithm>
#include <utility>

#include "formats/chunked_recording.hpp"
#include "formats/mcap_record.hpp"
#include "formats/mcap_topics.hpp"

namespace loopstone {
namespace {

constexpr std::uint64_t kFooterLength = 20;
/// What tells of a message all but its bytes.
constexpr std::uint64_t kMostMessageHead = kMcapHead + 22;

McapOp op_of(const RecordHead& record) { return static_cast<McapOp>(record.op); }

class McapReader final : public ChunkedRecording {
 public:
  McapReader(std::unique_ptr<RecordingBytes> bytes, const RecordingOptions& options)
      : ChunkedRecording(std::move(bytes), options, kMcapMagic.size()) {
    require_magic();
    load_summary();
    of_summary_ = channels_;
  }

  std::vector<std::string> notes() const override;

 private:
  void require_magic();

  void load_summary();
  bool has_right_checksum(std::uint64_t begin, std::uint64_t footer, std::uint32_t checksum);
  template <typename Use>
  bool for_each_in_summary(std::uint64_t begin, std::uint64_t end, Use&& use);
  bool has_schemas_of_channels(std::uint64_t begin, std::uint64_t end);
  bool index_chunk(std::string_view fields, std::uint64_t summary_at);
  bool count_messages(std::string_view fields);
  bool knows_indexed_channels() const;

  std::optional<McapRecord> head(std::uint64_t at) {
    return read_mcap_head(bytes_->view(at, kMcapHead));
  }
  std::optional<RecordHead> read_record(std::string_view bytes) const override;
  std::optional<RecordHead> record_at(std::uint64_t at) override {
    return read_record(bytes_->view(at, kMostMessageHead));
  }
  bool is_followed_well(const RecordHead& record, std::string_view behind) const override {
    return behind.empty() || may_follow(op_of(record), read_mcap_head(behind));
  }
  bool ends_well(std::uint64_t end) override;
  std::optional<std::size_t> find_record(std::string_view bytes, std::size_t from,
                                         bool last) const override {
    return find_mcap_record(bytes, from, last, knows_channel_);
  }
  bool is_chunk(std::uint64_t at) override;
  std::optional<ChunkHead> chunk_at(std::uint64_t at) override;
  std::string fault_of(const ChunkHead& chunk, std::string_view unpacked) const override;
  std::optional<std::size_t> topic_of(std::uint32_t channel) const override {
    return channels_.topic_of(channel);
  }
  bool describe(const RecordHead& record, std::string_view bytes) override {
    const std::string_view fields = bytes.substr(kMcapHead);
    return op_of(record) == McapOp::kSchema ? add_schema(fields) : add_channel(fields);
  }

  void begin() override;
  std::optional<RecordedMessage> step() override;

  bool add_schema(std::string_view fields) {
    return channels_.add_schema(fields, is_indexed_, topics_);
  }
  bool add_channel(std::string_view fields) {
    return channels_.add_channel(fields, is_indexed_, topics_);
  }

  const std::function<bool(std::uint16_t)> knows_channel_ = [this](std::uint16_t channel) {
    return channels_.knows_channel(channel);
  };

  McapTopics channels_{};
  McapTopics of_summary_{};
  bool was_closed_ = false;
  bool has_damaged_summary_ = false;
  bool has_all_channels_ = true;  ///< in the summary, as far as it says how many there are
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
  ChunkedRecording::begin();
  if (is_indexed_) return;
  channels_ = of_summary_;
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
    return !channel || channel->schema == 0 || channels_.knows_schema(channel->schema);
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
  has_all_channels_ = channels_.channels() >= channels;
  while (!counts.left().empty()) {
    const auto topic = channels_.topic_of(counts.number<std::uint16_t>());
    const auto messages = counts.number<std::uint64_t>();
    if (!counts.is_good()) return false;
    if (topic && messages < (std::uint64_t{1} << 48U))
      topics_.count(*topic, static_cast<std::int64_t>(messages));
  }
  return true;
}

bool McapReader::knows_indexed_channels() const {
  return std::all_of(index_.channels().begin(), index_.channels().end(),
                     [this](std::uint32_t channel) { return channels_.knows_channel(channel); });
}

// Between the chunks.

std::optional<RecordHead> McapReader::read_record(std::string_view bytes) const {
  const auto head = read_mcap_head(bytes);
  if (!head) return std::nullopt;
  RecordHead record{.op = static_cast<std::uint8_t>(head->op),
                    .head = kMcapHead,
                    .data = kMcapHead,
                    .end = head->end()};
  if (head->op == McapOp::kChunk) record.kind = RecordHead::Kind::kChunk;
  if (head->op == McapOp::kSchema || head->op == McapOp::kChannel) {
    record.kind = RecordHead::Kind::kTopic;
  }
  if (head->op != McapOp::kMessage) return record;
  record.kind = RecordHead::Kind::kMessage;
  if (const auto message = read_mcap_message(bytes.substr(kMcapHead))) {
    record.data = kMostMessageHead;
    record.channel = message->channel;
    record.recorded = message->recorded;
  }
  return record;
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

std::optional<RecordedMessage> McapReader::step() {
  const std::uint64_t at = at_;
  const auto record = record_at(at);
  if (!record) {
    pass_damage("there should be a record here, and is none");
    return std::nullopt;
  }
  if (record->kind == RecordHead::Kind::kChunk) {
    open_chunk();
    return std::nullopt;
  }
  const std::uint64_t left = data_end_ - at;
  if (record->end > left && end_before_next_chunk(at, data_end_) == data_end_) {
    if (bytes_->view(at, kMcapMagic.size()) == kMcapMagic) {  // one file behind another
      at_ = resume_ = at + kMcapMagic.size();
      return std::nullopt;
    }
    pass_damage("a record ends behind the end of the file");
    return std::nullopt;
  }
  const std::uint64_t stated_end = at + std::min(record->end, left + 1);
  const std::uint64_t end = end_before_next_chunk(at, stated_end);
  if (end < stated_end) {
    damage_.tell(at, "a record is longer than the place that it has");
    go_on_from(std::min(at + record->head, end));
    return std::nullopt;
  }
  if (end < data_end_ && !may_follow(op_of(*record), head(end))) {
    pass_damage("there should be a record here, and is none");
    return std::nullopt;
  }
  resume_ = at + record->head;
  at_ = end;
  return use_record(*record, at);
}

std::optional<ChunkHead> McapReader::chunk_at(std::uint64_t at) {
  const auto record = head(at);
  if (!record || record->op != McapOp::kChunk) return std::nullopt;
  const auto fields = read_mcap_chunk(bytes_->view(at + kMcapHead, kMostMcapChunkHead));
  if (!fields) return std::nullopt;
  ChunkHead chunk{.packing = packing_of(fields->compression),
                  .unpacked_size = fields->unpacked_size,
                  .checksum = fields->checksum,
                  .at = at,
                  .data = at + kMcapHead + fields->data,
                  .stated_size = fields->data_size};
  const std::uint64_t room = data_end_ > chunk.data ? data_end_ - chunk.data : 0;
  const std::uint64_t most = std::max(chunk.data, at + std::min(record->end(), data_end_ - at));
  const std::uint64_t data_end = chunk.data + std::min(chunk.stated_size, room);
  const std::uint64_t end = std::max(chunk.data, end_before_next_chunk(at, most));
  chunk.fits = chunk.stated_size <= room && end == at + record->end();
  chunk.end = end_of_chunk(end, data_end);
  chunk.stored_size = std::min(chunk.end, data_end) - chunk.data;
  return chunk;
}

std::string McapReader::fault_of(const ChunkHead& chunk, std::string_view unpacked) const {
  if (chunk.is_cut()) return "this chunk ends too early";
  if (unpacked.size() != chunk.unpacked_size) {
    return "this chunk does not unpack to the length that it states";
  }
  const bool is_wrong = chunk.checksum != 0 &&
                        libdeflate_crc32(0, unpacked.data(), unpacked.size()) != chunk.checksum;
  return is_wrong ? "the checksum of this chunk is wrong" : "";
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
