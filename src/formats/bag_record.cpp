#include "formats/bag_record.hpp"

#include <algorithm>

namespace loopstone {
namespace {

template <typename T>
bool take(std::string_view value, T& number) {
  if (value.size() != sizeof number) return false;
  number = little_endian<T>(value.data());
  return true;
}

Stamp stamp_of(std::string_view value) {
  const auto seconds = static_cast<std::int64_t>(little_endian<std::uint32_t>(value.data()));
  const auto rest = static_cast<std::int64_t>(little_endian<std::uint32_t>(value.data() + 4));
  return {seconds * 1'000'000'000 + rest};
}

/// False when a field has another length than its kind has.
bool take_field(std::string_view name, std::string_view value, BagFields& fields) {
  std::uint32_t number = 0;
  if (name == "conn") {
    if (!take(value, number)) return false;
    fields.connection = number;
    return true;
  }
  if (name == "time") {
    if (value.size() != 8) return false;
    fields.time = stamp_of(value);
    return true;
  }
  if (name == "compression") fields.compression = value;
  if (name == "topic") fields.topic = value;
  if (name == "size") return take(value, fields.size);
  if (name == "count") return take(value, fields.count);
  if (name == "index_pos") return take(value, fields.index_at);
  if (name == "chunk_pos") return take(value, fields.chunk_at);
  if (name == "chunk_count") return take(value, fields.chunks);
  if (name == "conn_count") return take(value, fields.connections);
  if (name == "encryptor") fields.is_encrypted = !value.empty();
  return true;
}

bool has_what_it_must(const BagFields& fields) {
  switch (fields.op) {
    case BagOp::kMessage:
      return fields.connection && fields.time;
    case BagOp::kConnection:
      return fields.connection && fields.topic;
    case BagOp::kChunk:
      return fields.compression.has_value();
    case BagOp::kIndex:
      return fields.connection.has_value();
    case BagOp::kBagHeader:
    case BagOp::kChunkInfo:
      return true;
  }
  return false;
}

bool is_sure(std::string_view bytes, std::size_t at, bool last) {
  const auto record = read_bag_record(bytes.substr(at));
  if (!record) return false;
  const BagOp op = record->fields.op;
  const std::uint64_t end = at + record->end();
  if (op == BagOp::kChunk) return packing_of(*record->fields.compression).has_value();
  if (op != BagOp::kMessage && op != BagOp::kConnection) return false;
  if (last && end == bytes.size()) return true;
  return end < bytes.size() &&
         read_bag_record(bytes.substr(static_cast<std::size_t>(end))).has_value();
}

}  // namespace

std::optional<BagRecord> read_bag_record(std::string_view bytes) {
  if (bytes.size() < 8) return std::nullopt;
  const auto length = little_endian<std::uint32_t>(bytes.data());
  if (length > kMostBagHeader || length > bytes.size() - 8) return std::nullopt;
  BagRecord record;
  bool has_op = false;
  bool sound = true;
  const auto use = [&](std::string_view name, std::string_view value) {
    if (name == "op") {
      sound = sound && value.size() == 1;
      has_op = sound;
      if (sound) record.fields.op = static_cast<BagOp>(value[0]);
    } else {
      sound = take_field(name, value, record.fields) && sound;
    }
  };
  if (!for_each_bag_field(bytes.substr(4, length), use)) return std::nullopt;
  if (!sound || !has_op || !has_what_it_must(record.fields)) return std::nullopt;
  record.data_at = std::uint64_t{length} + 8;
  record.data_size = little_endian<std::uint32_t>(bytes.data() + 4 + length);
  return record;
}

std::optional<std::size_t> find_bag_record(std::string_view bytes, std::size_t from, bool last) {
  constexpr std::string_view kOp = "op=";
  constexpr std::size_t kMostBefore = 512;  // of fields that may stand before it in a header
  constexpr std::size_t kLengths = 8;  // of the header and of the field, before the first field
  for (std::size_t op = bytes.find(kOp, from); op != bytes.npos; op = bytes.find(kOp, op + 1)) {
    if (op < from + kLengths) continue;
    const std::size_t nearest = op - kLengths;
    const std::size_t farthest = std::max(from, nearest - std::min(nearest, kMostBefore));
    for (std::size_t at = nearest + 1; at-- > farthest;) {
      const auto length = little_endian<std::uint32_t>(bytes.data() + at);
      if (length >= op - at && length <= kMostBagHeader && is_sure(bytes, at, last)) return at;
    }
  }
  return std::nullopt;
}

}  // namespace loopstone
