#include "formats/chunked_recording.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace loopstone {
namespace {

/// What is looked through at once for the next record behind damage.
constexpr std::uint64_t kSearchBytes = std::uint64_t{1} << 22;

}  // namespace

ChunkedRecording::ChunkedRecording(std::unique_ptr<RecordingBytes> bytes,
                                   const RecordingOptions& options, std::uint64_t first)
    : bytes_(std::move(bytes)),
      topics_(options.memory, bytes_->size(), bytes_->name()),
      damage_(options.on_damage, bytes_->name()),
      data_end_(bytes_->size()),
      at_(first),
      resume_(first),
      memory_(options.memory),
      first_(first) {}

void ChunkedRecording::begin() {
  at_ = resume_ = first_;
  in_chunk_ = false;
}

ReadProgress ChunkedRecording::progress() const {
  const std::uint64_t done = at_ >= data_end_ ? bytes_->size() : at_;
  return {static_cast<std::int64_t>(done), static_cast<std::int64_t>(bytes_->size())};
}

// Between the chunks.

std::uint64_t ChunkedRecording::end_before_next_chunk(std::uint64_t at, std::uint64_t end) {
  return index_.first_in(at + 1, end, [this](std::uint64_t chunk) { return is_chunk(chunk); })
      .value_or(end);
}

std::optional<std::uint64_t> ChunkedRecording::find_chunk_from(std::uint64_t at) {
  constexpr std::uint64_t kAnywhere = std::numeric_limits<std::uint64_t>::max();
  return index_.first_in(at, kAnywhere, [this](std::uint64_t chunk) { return is_chunk(chunk); });
}

std::optional<RecordedMessage> ChunkedRecording::next() {
  if (is_displaced_ && in_chunk_ && chunk_data_ != 0) {
    chunk_ = bytes_->view(chunk_data_, chunk_.size());
  }
  is_displaced_ = false;
  while (true) {
    if (in_chunk_) {
      if (auto message = next_in_chunk()) return message;
    } else {
      if (at_ >= data_end_) return std::nullopt;
      if (auto message = step()) return message;
    }
  }
}

void ChunkedRecording::pass_damage(const std::string& reason) {
  damage_.tell(at_, reason);
  go_on_from(resume_);
}

void ChunkedRecording::go_on_from(std::uint64_t place) {
  const std::uint64_t limit = find_chunk_from(place).value_or(data_end_);
  at_ = resume_ = search(place, limit).value_or(limit);
}

std::optional<std::uint64_t> ChunkedRecording::search(std::uint64_t from, std::uint64_t limit) {
  for (std::uint64_t at = from; at < limit; at += kSearchBytes / 2) {
    const std::string_view bytes = bytes_->view(at, std::min(kSearchBytes, limit - at));
    const bool last = at + bytes.size() >= limit;
    if (const auto found = find_record(bytes, 0, last)) return at + *found;
    if (last || bytes.empty()) break;
  }
  return std::nullopt;
}

std::optional<RecordedMessage> ChunkedRecording::use_record(const RecordHead& record,
                                                            std::uint64_t at) {
  if (record.kind != RecordHead::Kind::kMessage && record.kind != RecordHead::Kind::kTopic) {
    return std::nullopt;
  }
  const std::string_view bytes = bytes_->view(at, record.end);
  if (bytes.size() < record.end) {  // somebody cut it meanwhile
    damage_.tell(at, "a record ends behind the end of the file");
    return std::nullopt;
  }
  return use(record, bytes, {.at = static_cast<std::int64_t>(at)});
}

/// \param bytes  of the whole record
std::optional<RecordedMessage> ChunkedRecording::use(const RecordHead& record,
                                                     std::string_view bytes, MessagePlace place) {
  const auto at = static_cast<std::uint64_t>(place.at);
  if (record.kind == RecordHead::Kind::kTopic && !describe(record, bytes)) {
    damage_.tell(at, "what describes a topic is damaged");
  }
  if (record.kind != RecordHead::Kind::kMessage) return std::nullopt;
  const auto topic = topic_of(record.channel);
  if (!topic) {
    damage_.tell(at, "a message of a topic that nothing describes");
    return std::nullopt;
  }
  if (!topics_.is_wanted(*topic)) return std::nullopt;
  bytes.remove_prefix(static_cast<std::size_t>(record.data));
  place.recorded = record.recorded;
  place.size = bytes.size();
  return RecordedMessage{.topic = *topic,
                         .recorded = record.recorded,
                         .bytes = {bytes.data(), bytes.size()},
                         .file = &bytes_->name(),
                         .offset = place.at,
                         .place = place};
}

// In a chunk.

bool ChunkedRecording::may_be_skipped(std::uint64_t at) const {
  if (!is_indexed_ || topics_.wants_all()) return false;
  const ChunkIndex::Chunk* const chunk = index_.find(at);
  if (chunk == nullptr || chunk->channels == 0) return false;
  const auto first = index_.channels().begin() + static_cast<std::ptrdiff_t>(chunk->first);
  return std::none_of(first, first + static_cast<std::ptrdiff_t>(chunk->channels),
                      [this](std::uint32_t channel) {
                        const auto topic = topic_of(channel);
                        return !topic || topics_.is_wanted(*topic);
                      });
}

UnpackedChunk ChunkedRecording::unpack(ChunkUnpacker& unpacker, const ChunkHead& chunk) {
  const std::uint64_t most_bytes = memory_.allowed_bytes(bytes_->size(), Growth::kNumbers);
  memory_.require(chunk.stored_size, bytes_->size(), Growth::kNumbers, {bytes_->name()});
  return unpacker.unpack(*chunk.packing, bytes_->view(chunk.data, chunk.stored_size),
                         chunk.unpacked_size, most_bytes, stop_);
}

void ChunkedRecording::open_chunk() {
  const auto found = chunk_at(at_);
  if (!found) return pass_damage("the head of a chunk is damaged or cut");
  const ChunkHead& chunk = *found;
  at_ = resume_ = chunk.end;
  if (chunk.fits && may_be_skipped(chunk.at)) return;
  if (!chunk.packing) {
    damage_.tell(chunk.at, "a chunk is packed in a way that is not known");
    if (!ends_well(chunk.end)) go_on_from(chunk.at + 1);
    return;
  }
  const UnpackedChunk unpacked = unpack(unpacker_, chunk);
  const std::string damage =
      unpacked.damage.empty() ? fault_of(chunk, unpacked.bytes) : unpacked.damage;
  told_chunk_ = !damage.empty();
  if (told_chunk_) damage_.tell(chunk.at, damage);
  chunk_ = unpacked.bytes;
  chunk_at_ = chunk.at;
  chunk_data_ = *chunk.packing == Packing::kNone ? chunk.data : 0;
  in_chunk_at_ = in_chunk_resume_ = 0;
  in_chunk_ = true;
  if (*chunk.packing == Packing::kNone) return;
  // When it ends before the chunk does, or is damaged, the chunk's length may be wrong.
  const std::uint64_t end = chunk.data + unpacked.consumed;
  if ((told_chunk_ || end < chunk.end) && (chunk.is_cut() || !ends_well(chunk.end))) {
    go_on_from(told_chunk_ ? chunk.data : end);
  }
}

std::uint64_t ChunkedRecording::end_of_chunk(std::uint64_t end, std::uint64_t other_end) {
  if (end == other_end) return end;
  if (end != data_end_ && ends_well(end)) return end;
  if (other_end != data_end_ && ends_well(other_end)) return other_end;
  return std::min(end, other_end);
}

std::optional<RecordedMessage> ChunkedRecording::next_in_chunk() {
  while (in_chunk_at_ < chunk_.size()) {
    const std::string_view left = chunk_.substr(in_chunk_at_);
    const auto record = read_record(left);
    if (record && record->kind == RecordHead::Kind::kChunk && chunk_data_ != 0) {
      at_ = resume_ = chunk_data_ + in_chunk_at_;  // it ended before, and did not say so
      in_chunk_ = false;
      return std::nullopt;
    }
    if (!record || record->end > left.size() ||
        !is_followed_well(*record, left.substr(static_cast<std::size_t>(record->end)))) {
      if (!pass_damage_in_chunk()) break;
      continue;
    }
    MessagePlace place;
    if (chunk_data_ != 0) {
      place.at = static_cast<std::int64_t>(chunk_data_ + in_chunk_at_);
    } else {
      place.at = static_cast<std::int64_t>(chunk_at_);
      place.in_chunk = static_cast<std::int64_t>(in_chunk_at_);
    }
    in_chunk_resume_ = in_chunk_at_ + static_cast<std::size_t>(record->head);
    in_chunk_at_ += static_cast<std::size_t>(record->end);
    const std::string_view bytes = left.substr(0, static_cast<std::size_t>(record->end));
    if (auto message = use(*record, bytes, place)) return message;
  }
  in_chunk_ = false;
  if (told_chunk_ && chunk_data_ != 0 && at_ == resume_) resume_ = chunk_data_ + in_chunk_resume_;
  return std::nullopt;
}

/// Goes back to the beginning of the last record, whose length may be wrong. False when nothing
/// more is found in this chunk.
bool ChunkedRecording::pass_damage_in_chunk() {
  if (!told_chunk_) damage_.tell(chunk_at_, "a record in this chunk is damaged");
  told_chunk_ = true;
  const auto found = find_record(chunk_, in_chunk_resume_, true);
  if (!found) return false;
  in_chunk_at_ = *found;
  in_chunk_resume_ = *found + 1;
  return true;
}

// By place.

std::span<const char> ChunkedRecording::bytes_at(const MessagePlace& place) {
  is_displaced_ = true;
  const std::string_view bytes = bytes_from(place);
  const auto record = read_record(bytes);
  if (!record || record->kind != RecordHead::Kind::kMessage || record->end > bytes.size() ||
      record->recorded != place.recorded || record->end - record->data != place.size) {
    throw_message_gone({bytes_->name(), {}, place.at});
  }
  return {bytes.data() + record->data, static_cast<std::size_t>(place.size)};
}

/// From where the record of a message should begin; nothing when there is no such place.
std::string_view ChunkedRecording::bytes_from(const MessagePlace& place) {
  const auto at = static_cast<std::uint64_t>(place.at);
  if (place.in_chunk == MessagePlace::kNoChunk) {
    const auto record = record_at(at);
    const bool fits = record && record->end <= bytes_->size() - at;
    return fits ? bytes_->view(at, record->end) : std::string_view();
  }
  if (placed_at_ != at) {
    placed_at_ = 0;
    const auto chunk = at < data_end_ ? chunk_at(at) : std::nullopt;
    if (!chunk || chunk->packing.value_or(Packing::kNone) == Packing::kNone) return {};
    placed_chunk_ = unpack(placed_unpacker_, *chunk).bytes;
    placed_at_ = at;
  }
  const auto in_chunk = static_cast<std::size_t>(place.in_chunk);
  return in_chunk < placed_chunk_.size() ? placed_chunk_.substr(in_chunk) : std::string_view();
}

}  // namespace loopstone
