#include "formats/mcap_record.hpp"

#include <algorithm>
#include <array>

#include "formats/chunk_unpack.hpp"

namespace loopstone {
namespace {

/// No file is longer.
constexpr std::uint64_t kMostLength = std::uint64_t{1} << 40;

/// Of the kinds from 0 on, the shortest that their fields can be.
constexpr std::array<std::uint64_t, 16> kLeastLengths{0,  8,  20, 14, 16, 22, 40, 6,
                                                      64, 36, 48, 46, 8,  20, 17, 4};

bool is_sure_chunk(std::string_view bytes, const McapRecord& record) {
  constexpr std::uint64_t kMostTrailing = 1024;  // bytes behind what is known of a chunk
  const auto chunk = read_mcap_chunk(bytes.substr(kMcapHead));
  if (!chunk || !packing_of(chunk->compression) || chunk->data_size >= kMostLength) return false;
  const std::uint64_t needed = chunk->data + chunk->data_size;
  return needed <= record.length && record.length - needed <= kMostTrailing;
}

bool is_sure(std::string_view bytes, bool last,
             const std::function<bool(std::uint16_t)>& knows_channel) {
  const auto record = read_mcap_head(bytes);
  if (!record || record->length >= kMostLength) return false;
  if (record->op == McapOp::kChunk) return is_sure_chunk(bytes, *record);
  if (record->end() > bytes.size()) return false;
  const auto end = static_cast<std::size_t>(record->end());
  const std::string_view fields = bytes.substr(kMcapHead, end - kMcapHead);
  if (record->op == McapOp::kSchema && !read_mcap_schema(fields)) return false;
  if (record->op == McapOp::kChannel && !read_mcap_channel(fields)) return false;
  if (record->op == McapOp::kMessage) {
    const auto message = read_mcap_message(fields);
    if (!message || !knows_channel(message->channel)) return false;
  }
  if (end == bytes.size()) return last;
  const auto next = read_mcap_head(bytes.substr(end));
  return next && static_cast<std::size_t>(next->op) < kLeastLengths.size() &&
         next->length < kMostLength;
}

}  // namespace

std::optional<McapRecord> read_mcap_head(std::string_view bytes) {
  if (bytes.size() < kMcapHead || bytes[0] == 0) return std::nullopt;
  const auto op = static_cast<unsigned char>(bytes[0]);
  const auto length = little_endian<std::uint64_t>(bytes.data() + 1);
  if (op < kLeastLengths.size() && length < kLeastLengths[op]) return std::nullopt;
  return McapRecord{static_cast<McapOp>(op), length};
}

bool may_follow(McapOp op, const std::optional<McapRecord>& next) {
  const auto is_known = [](McapOp kind) { return static_cast<std::size_t>(kind) < 16; };
  return is_known(op) || (next && (is_known(next->op) || next->op == op));
}

std::optional<McapSchema> read_mcap_schema(std::string_view bytes) {
  McapFields in(bytes);
  McapSchema schema;
  schema.id = in.number<std::uint16_t>();
  schema.name = in.text();
  schema.encoding = in.text();
  schema.text = in.text();
  return in.is_good() ? std::optional(schema) : std::nullopt;
}

std::optional<McapChannel> read_mcap_channel(std::string_view bytes) {
  McapFields in(bytes);
  McapChannel channel;
  channel.id = in.number<std::uint16_t>();
  channel.schema = in.number<std::uint16_t>();
  channel.topic = in.text();
  channel.encoding = in.text();
  channel.metadata = in.text();
  return in.is_good() ? std::optional(channel) : std::nullopt;
}

std::optional<McapMessage> read_mcap_message(std::string_view bytes) {
  constexpr std::uint64_t kMostTime = (std::uint64_t{1} << 62U) - 1;
  McapFields in(bytes);
  McapMessage message;
  message.channel = in.number<std::uint16_t>();
  (void)in.number<std::uint32_t>();  // a count of the sender
  message.recorded = {static_cast<std::int64_t>(std::min(in.number<std::uint64_t>(), kMostTime))};
  (void)in.number<std::uint64_t>();  // when it was sent
  message.bytes = in.left();
  return in.is_good() ? std::optional(message) : std::nullopt;
}

std::optional<McapChunk> read_mcap_chunk(std::string_view bytes) {
  McapFields in(bytes);
  McapChunk chunk;
  (void)in.take(16);  // the times of its messages
  chunk.unpacked_size = in.number<std::uint64_t>();
  chunk.checksum = in.number<std::uint32_t>();
  chunk.compression = in.text();
  chunk.data_size = in.number<std::uint64_t>();
  chunk.data = bytes.size() - in.left().size();
  return in.is_good() ? std::optional(chunk) : std::nullopt;
}

std::string_view mcap_map_value(std::string_view map, std::string_view name) {
  McapFields in(map);
  while (in.is_good() && !in.left().empty()) {
    const std::string_view key = in.text();
    const std::string_view value = in.text();
    if (in.is_good() && key == name) return value;
  }
  return {};
}

std::optional<std::size_t> find_mcap_record(
    std::string_view bytes, std::size_t from, bool last,
    const std::function<bool(std::uint16_t)>& knows_channel) {
  if (bytes.size() < kMcapHead) return std::nullopt;
  for (std::size_t at = from; at <= bytes.size() - kMcapHead; ++at) {
    const auto op = static_cast<unsigned char>(bytes[at]);
    if (op < 3 || op > 6) continue;
    // The high bytes of a length that a file can have.
    if (bytes[at + 8] != 0 || bytes[at + 7] != 0 || bytes[at + 6] != 0) continue;
    if (is_sure(bytes.substr(at), last, knows_channel)) return at;
  }
  return std::nullopt;
}

}  // namespace loopstone
